// Storage of material points on DMSwarm, and their migration in one sparse exchange.
#include "points/points.hpp"

#include "base/exchange.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

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

/// A field's name in the swarm, which has one of its own for ids.
static const char *SwarmName(const PointFieldInfo &field, int place) { return place == kId ? DMSwarmField_pid : field.name; }

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
  for (int k = 0; k < kPointFields; ++k) {
    const PointFieldInfo &field = table_[k];
    if (field.components == 0 || k == kId) continue;
    const PetscDataType type = kPetscTypes[static_cast<int>(field.type)];
    PetscCall(DMSwarmRegisterPetscDatatypeField(swarm_, field.name, field.components, type));
  }
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
    if (table_[k].components) PetscCall(DMSwarmGetField(swarm_, SwarmName(table_[k], k), nullptr, nullptr, &data_[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::ReleaseFields()
{
  PetscFunctionBeginUser;
  for (int k = 0; k < kPointFields; ++k)
    if (data_[k]) PetscCall(DMSwarmRestoreField(swarm_, SwarmName(table_[k], k), nullptr, nullptr, &data_[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PointArrays Points::Arrays()
{
  PointArrays arrays{};
  arrays.count = count_, arrays.dim = dim_;
  arrays.stress_components = table_[kStress].components, arrays.rate_components = table_[kShortWaveStress].components;
  arrays.loads = table_[kLoadShare].components, arrays.history_components = table_[kHistory].components;
  ForEachArray(arrays, [this](PointField field, auto *&array, int) {
    array = static_cast<std::remove_reference_t<decltype(array)>>(data_[field]);
  });
  return arrays;
}

void Points::RecordChange()
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
  RecordChange();
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

/// The rings in which records change places so that record k becomes what was at order[k]: each place is followed by that whose
/// record it gets; the last of a ring, as ~place, gets that of the first.
static std::vector<int> RingsOf(std::vector<int> order)
{
  std::vector<int> rings;
  rings.reserve(order.size());
  const int count = static_cast<int>(order.size());
  for (int first = 0; first < count; ++first) {
    int p = first;
    if (order[first] == first || order[first] < 0) continue; // stays, or has been in a ring
    for (int next; (next = std::exchange(order[p], -1)) != first; p = next) rings.push_back(p);
    rings.push_back(~p);
  }
  return rings;
}

/// Moves records in rings if they are of so many bytes; with 0, of any.
template <std::size_t bytes> static bool MoveInRings(char *data, std::size_t record, const std::vector<int> &rings)
{
  if (bytes != 0 && bytes != record) return false;
  const std::size_t size = bytes ? bytes : record; // copies of a constant size are a few instructions
  const auto copy = [=](char *to, const char *from) { std::memcpy(to, from, size); };
  std::vector<char> held(size);
  for (std::size_t k = 0; k < rings.size(); ++k) {
    int p = std::max(rings[k], ~rings[k]);
    copy(held.data(), data + size * p);
    for (; rings[k] >= 0; ++k) {
      const int next = std::max(rings[k + 1], ~rings[k + 1]);
      copy(data + size * p, data + size * next);
      p = next;
    }
    copy(data + size * p, held.data());
  }
  return true;
}

void Points::Reorder(std::vector<int> order)
{
  const std::vector<int> rings = RingsOf(std::move(order));
  for (const auto &[data, size] : Memory())
    MoveInRings<4>(data, size, rings) || MoveInRings<8>(data, size, rings) || MoveInRings<16>(data, size, rings) ||
        MoveInRings<24>(data, size, rings) || MoveInRings<32>(data, size, rings) || MoveInRings<0>(data, size, rings);
  RecordChange();
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
  RecordChange();
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

/// Appends the points of records; origins [records]: the rank and the place that each comes from.
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
