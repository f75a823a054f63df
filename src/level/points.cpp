// Storage of material points on DMSwarm, and their migration in one sparse exchange.
#include "level/points.hpp"

#include "base/exchange.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace mlgimp
{

PetscErrorCode Points::Create(MPI_Comm comm, GeometryKind geometry, int loads, int history_components)
{
  PetscFunctionBeginUser;
  table_ = PointFieldTable(geometry, loads, history_components);
  dim_ = table_[kPosition].components;
  PetscCall(CreateSwarm(comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A swarm with the table's fields and room for `capacity_` points.
PetscErrorCode Points::CreateSwarm(MPI_Comm comm)
{
  constexpr PetscDataType kPetscTypes[] = {PETSC_REAL, PETSC_ENUM, PETSC_INT64}; // by FieldType
  static_assert(sizeof(PetscEnum) == sizeof(int), "PETSc's versions have no other name for an int of any PetscInt");
  PetscFunctionBeginUser;
  PetscCall(DMCreate(comm, swarm_.Out()));
  PetscCall(DMSetType(swarm_, DMSWARM));
  PetscCall(DMSetDimension(swarm_, dim_));
  PetscCall(DMSwarmSetType(swarm_, DMSWARM_BASIC));
  PetscCall(DMSwarmInitializeFieldRegister(swarm_));
  for (const PointFieldInfo &field : table_)
    if (field.components)
      PetscCall(
          DMSwarmRegisterPetscDatatypeField(swarm_, field.name, field.components, kPetscTypes[static_cast<int>(field.type)]));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm_));
  PetscCall(DMSwarmSetLocalSizes(swarm_, capacity_, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::MoveTo(MPI_Comm comm)
{
  int relation = MPI_UNEQUAL;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_compare(Comm(), comm, &relation));
  if (relation == MPI_IDENT || relation == MPI_CONGRUENT) PetscFunctionReturn(PETSC_SUCCESS);
  Points old; // gives its fields back, and the swarm with them, at its end
  std::swap(old.swarm_, swarm_), std::swap(old.data_, data_), old.table_ = table_;
  PetscCall(CreateSwarm(comm));
  if (capacity_ == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AccessFields());
  const std::vector<FieldMemory> before = old.Memory(), now = Memory();
  for (std::size_t k = 0; k < now.size(); ++k) std::copy_n(before[k].data, before[k].bytes * count_, now[k].data);
  PetscFunctionReturn(PETSC_SUCCESS);
}

Points::~Points()
{
  PetscFunctionBegin;
  PetscCallVoid(ReleaseFields());
  PetscFunctionReturnVoid();
}

PetscErrorCode Points::AccessFields()
{
  PetscFunctionBeginUser;
  for (int k = 0; k < kPointFields; ++k)
    if (table_[k].components) PetscCall(DMSwarmGetField(swarm_, table_[k].name, nullptr, nullptr, &data_[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::ReleaseFields()
{
  PetscFunctionBeginUser;
  for (int k = 0; k < kPointFields; ++k)
    if (data_[k]) PetscCall(DMSwarmRestoreField(swarm_, table_[k].name, nullptr, nullptr, &data_[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PointArrays Points::Arrays()
{
  const auto real = [this](PointField field) { return static_cast<double *>(data_[field]); };
  const auto integer = [this](PointField field) { return static_cast<int *>(data_[field]); };
  return {count_,
          dim_,
          table_[kStress].components,
          table_[kShortWaveStress].components,
          static_cast<std::int64_t *>(data_[kId]),
          real(kPosition),
          real(kVelocity),
          real(kDeformation),
          real(kStress),
          real(kShortWaveStress),
          real(kMass),
          real(kHalfSize),
          real(kInitialRadius),
          real(kInitialPosition),
          integer(kBody),
          integer(kFaces),
          real(kLoadShare),
          real(kHistory),
          table_[kLoadShare].components,
          table_[kHistory].components};
}

void Points::NoteChange()
{
  surface_known_ = false;
  ++version_;
}

PetscErrorCode Points::Resize(int count)
{
  PetscFunctionBeginUser;
  if (count > capacity_) { // the swarm has as many points as there is room for: setting its size clears the rest
    PetscCall(ReleaseFields());
    capacity_ = capacity_ == 0 ? count : count + count / 10;
    PetscCall(DMSwarmSetLocalSizes(swarm_, capacity_, 0));
    PetscCall(AccessFields());
  }
  count_ = count;
  NoteChange();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::View(const std::string &prefix)
{
  PetscViewer viewer;
  PetscViewerFormat format;
  PetscBool on, hdf5;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsCreateViewer(Comm(), nullptr, prefix.c_str(), "-points_view", &viewer, &format, &on));
  if (!on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerPushFormat(viewer, format));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERHDF5, &hdf5));
  PetscCall(hdf5 ? ViewFields(prefix, viewer) : ViewSwarm(prefix, viewer));
  PetscCall(PetscViewerPopFormat(viewer));
  PetscCall(PetscViewerDestroy(&viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::ViewSwarm(const std::string &prefix, PetscViewer viewer)
{
  PetscFunctionBeginUser;
  PetscCall(ReleaseFields());
  PetscCall(DMSwarmSetLocalSizes(swarm_, count_, capacity_ - count_)); // the points that there are, with the same room
  PetscCall(PetscObjectSetName(swarm_.Object(), (prefix + "points").c_str()));
  PetscCall(DMView(swarm_, viewer));
  PetscCall(AccessFields());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What DMView does not write of points that no cells of PETSc hold.
PetscErrorCode Points::ViewFields(const std::string &prefix, PetscViewer viewer) const
{
  PetscFunctionBeginUser;
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = table_[k];
    VecHandle values;
    if (field.type != FieldType::kReal || field.components == 0) continue;
    PetscCall(VecCreateMPIWithArray(Comm(), field.components, PetscInt{count_} * field.components, PETSC_DETERMINE,
                                    static_cast<double *>(data_[k]), values.Out()));
    PetscCall(PetscObjectSetName(values.Object(), (prefix + field.name).c_str()));
    PetscCall(VecView(values, viewer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Points::Reorder(const std::vector<int> &order)
{
  std::vector<char> held;
  for (const FieldMemory &field : Memory()) {
    std::vector<bool> done(count_);
    held.resize(field.bytes);
    for (int first = 0; first < count_; ++first) { // in place: points change places in rings
      if (done[first] || order[first] == first) continue;
      int p = first;
      std::memcpy(held.data(), field.Of(first), field.bytes);
      for (; order[p] != first; p = order[p]) std::memcpy(field.Of(p), field.Of(order[p]), field.bytes), done[p] = true;
      std::memcpy(field.Of(p), held.data(), field.bytes), done[p] = true;
    }
  }
  NoteChange();
}

const std::vector<int> &Points::SurfacePoints()
{
  const int *const faces = static_cast<int *>(data_[kFaces]);
  if (surface_known_) return surface_;
  surface_.clear();
  for (int p = 0; p < count_; ++p)
    if (faces[p]) surface_.push_back(p);
  surface_known_ = true;
  return surface_;
}

std::vector<Points::FieldMemory> Points::Memory() const
{
  std::vector<FieldMemory> memory;
  for (int k = 0; k < kPointFields; ++k)
    if (const std::size_t bytes = FieldBytes(table_[k]); bytes > 0) memory.push_back({static_cast<char *>(data_[k]), bytes});
  return memory;
}

void Points::Copy(int source, int target)
{
  for (const FieldMemory &field : Memory()) std::memcpy(field.Of(target), field.Of(source), field.bytes);
}

void Points::Remove(const std::vector<int> &holes)
{
  const std::vector<FieldMemory> memory = Memory();
  int last = count_ - 1;
  std::size_t top = holes.size();
  if (holes.empty()) return;
  for (std::size_t k = 0; k < top; ++k, --last) {
    while (top > k && holes[top - 1] == last) --top, --last;
    if (k >= top) break;
    for (const FieldMemory &field : memory) std::memcpy(field.Of(holes[k]), field.Of(last), field.bytes);
  }
  count_ -= static_cast<int>(holes.size());
  NoteChange();
}

void Points::Pack(int point, char *record) const
{
  for (const FieldMemory &field : Memory()) {
    std::memcpy(record, field.Of(point), field.bytes);
    record += field.bytes;
  }
}

void Points::Unpack(const char *record, int point)
{
  for (const FieldMemory &field : Memory()) {
    std::memcpy(field.Of(point), record, field.bytes);
    record += field.bytes;
  }
}

/// Sends copies of points. incoming: records of a PetscSFNode, the rank and the place among its migrants that a point comes from,
/// and all of its fields. Collective.
static PetscErrorCode SendPoints(MPI_Comm comm, const Points &from, const Migrants &migrants, std::vector<char> *incoming)
{
  const std::size_t n = migrants.points.size(), bytes = sizeof(PetscSFNode) + from.RecordBytes();
  std::vector<std::size_t> order(n);
  std::vector<PetscMPIInt> ranks(n);
  std::vector<char> records(n * bytes);
  PetscFunctionBeginUser;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return migrants.ranks[a] < migrants.ranks[b]; });
  for (std::size_t k = 0; k < n; ++k) {
    const PetscSFNode origin = {RankIn(comm), static_cast<PetscInt>(k)};
    ranks[k] = migrants.ranks[order[k]];
    std::memcpy(&records[k * bytes], &origin, sizeof origin);
    from.Pack(migrants.points[order[k]], &records[k * bytes + sizeof origin]);
  }
  PetscCall(ExchangeBytes(comm, bytes, ranks, kAnyToAny, records.data(), incoming));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds the points of records, and tells where they come from.
static PetscErrorCode Receive(const std::vector<char> &incoming, Points &to, std::vector<PetscSFNode> *origins)
{
  const std::size_t bytes = sizeof(PetscSFNode) + to.RecordBytes(), n = incoming.size() / bytes;
  const int before = to.Count();
  PetscFunctionBeginUser;
  origins->resize(n);
  if (n > 0) PetscCall(to.Resize(before + static_cast<int>(n)));
  for (std::size_t k = 0; k < n; ++k) {
    std::memcpy(&(*origins)[k], &incoming[k * bytes], sizeof(PetscSFNode));
    to.Unpack(&incoming[k * bytes + sizeof(PetscSFNode)], before + static_cast<int>(k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovePoints(MPI_Comm comm, Points &from, Points &to, const Migrants &migrants)
{
  std::vector<char> incoming;
  std::vector<PetscSFNode> origins;
  PetscFunctionBeginUser;
  PetscCall(SendPoints(comm, from, migrants, &incoming));
  from.Remove(migrants.points);
  PetscCall(Receive(incoming, to, &origins));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyPoints(MPI_Comm comm, Points &from, Points &to, const Migrants &migrants, std::vector<PetscSFNode> *origins)
{
  std::vector<char> incoming;
  PetscFunctionBeginUser;
  PetscCall(SendPoints(comm, from, migrants, &incoming));
  PetscCall(Receive(incoming, to, origins));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AppendPoints(const Points &from, const std::vector<int> &points, Points &to)
{
  std::vector<char> record(from.RecordBytes());
  int next = to.Count();
  PetscFunctionBeginUser;
  if (points.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(to.Resize(next + static_cast<int>(points.size())));
  for (int point : points) {
    from.Pack(point, record.data());
    to.Unpack(record.data(), next++);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
