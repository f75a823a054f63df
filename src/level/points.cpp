// Storage of material points on DMSwarm, and their migration in one sparse exchange.
#include "level/points.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace mlgimp
{

static PetscDataType PetscType(FieldType type)
{
  switch (type) {
  case FieldType::kInt32:
    return PETSC_INT;
  case FieldType::kInt64:
    return PETSC_INT64;
  default:
    return PETSC_REAL;
  }
}

PetscErrorCode Points::Create(int loads, int history_components)
{
  static_assert(sizeof(PetscInt) == sizeof(int), "point fields of type kInt32 are stored as PetscInt");
  PetscFunctionBeginUser;
  table_ = PointFieldTable(loads, history_components);
  PetscCall(DMCreate(PETSC_COMM_SELF, swarm_.Out()));
  PetscCall(DMSetType(swarm_, DMSWARM));
  PetscCall(DMSetDimension(swarm_, 2));
  PetscCall(DMSwarmSetType(swarm_, DMSWARM_BASIC));
  PetscCall(DMSwarmInitializeFieldRegister(swarm_));
  for (const PointFieldInfo &field : table_)
    if (field.components)
      PetscCall(DMSwarmRegisterPetscDatatypeField(swarm_, field.name, field.components, PetscType(field.type)));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm_));
  PetscCall(DMSwarmSetLocalSizes(swarm_, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

Points::~Points()
{
  PetscFunctionBegin;
  PetscCallVoid(ReleaseFields());
  PetscFunctionReturnVoid();
}

PetscErrorCode Points::ReleaseFields()
{
  PetscFunctionBeginUser;
  if (!have_fields_) PetscFunctionReturn(PETSC_SUCCESS);
  for (int k = 0; k < kPointFields; ++k)
    if (table_[k].components) PetscCall(DMSwarmRestoreField(swarm_, table_[k].name, nullptr, nullptr, &data_[k]));
  have_fields_ = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::Field(PointField field, void **data)
{
  PetscFunctionBeginUser;
  if (!have_fields_) {
    for (int k = 0; k < kPointFields; ++k)
      if (table_[k].components) PetscCall(DMSwarmGetField(swarm_, table_[k].name, nullptr, nullptr, &data_[k]));
    have_fields_ = true;
  }
  *data = data_[field];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::Arrays(PointArrays *arrays)
{
  void *first = nullptr;
  PetscFunctionBeginUser;
  PetscCall(Field(kId, &first));
  auto real = [this](PointField field) { return static_cast<double *>(data_[field]); };
  auto integer = [this](PointField field) { return static_cast<int *>(data_[field]); };
  *arrays = {count_,
             static_cast<std::int64_t *>(first),
             real(kPosition),
             real(kVelocity),
             real(kDeformation),
             real(kStress),
             real(kShortWaveStress),
             real(kMass),
             real(kHalfSize),
             integer(kBody),
             integer(kFaces),
             real(kLoadShare),
             real(kHistory),
             table_[kLoadShare].components,
             table_[kHistory].components};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::Resize(int count)
{
  PetscFunctionBeginUser;
  if (count > capacity_) { // the swarm has as many points as there is room for: setting its size clears the rest
    PetscCall(ReleaseFields());
    capacity_ = capacity_ == 0 ? count : count + count / 10;
    PetscCall(DMSwarmSetLocalSizes(swarm_, capacity_, 0));
  }
  count_ = count;
  surface_known_ = false;
  ++version_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::Reorder(const std::vector<int> &order)
{
  std::vector<char> scratch;
  PetscFunctionBeginUser;
  for (int k = 0; k < kPointFields; ++k) {
    if (!table_[k].components) continue;
    const std::size_t bytes = FieldBytes(table_[k]);
    void *data = nullptr;
    PetscCall(Field(static_cast<PointField>(k), &data));
    char *field = static_cast<char *>(data);
    scratch.resize(bytes * count_);
    for (int p = 0; p < count_; ++p) std::memcpy(&scratch[bytes * p], field + bytes * order[p], bytes);
    std::copy(scratch.begin(), scratch.end(), field);
  }
  surface_known_ = false;
  ++version_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Points::SurfacePoints(const std::vector<int> **indices)
{
  PetscFunctionBeginUser;
  if (!surface_known_) {
    void *faces = nullptr;
    PetscCall(Field(kFaces, &faces));
    surface_.clear();
    for (int p = 0; p < count_; ++p)
      if (static_cast<int *>(faces)[p]) surface_.push_back(p);
    surface_known_ = true;
  }
  *indices = &surface_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace
{

/// Copies whole points between the arrays of fields and contiguous records.
class RecordCopier
{
public:
  static PetscErrorCode Create(Points &points, RecordCopier *copier)
  {
    PetscFunctionBeginUser;
    copier->fields_.clear();
    copier->record_bytes_ = 0;
    for (int k = 0; k < kPointFields; ++k) {
      const std::size_t bytes = FieldBytes(points.Table()[k]);
      if (bytes == 0) continue;
      void *data = nullptr;
      PetscCall(points.Field(static_cast<PointField>(k), &data));
      copier->fields_.push_back({static_cast<char *>(data), bytes});
      copier->record_bytes_ += bytes;
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  std::size_t RecordBytes() const { return record_bytes_; }
  void Pack(int point, char *record) const
  {
    for (const auto &f : fields_) {
      std::memcpy(record, f.data + f.bytes * point, f.bytes);
      record += f.bytes;
    }
  }
  void Unpack(const char *record, int point) const
  {
    for (const auto &f : fields_) {
      std::memcpy(f.data + f.bytes * point, record, f.bytes);
      record += f.bytes;
    }
  }
  void Copy(int source, int target) const
  {
    for (const auto &f : fields_) std::memcpy(f.data + f.bytes * target, f.data + f.bytes * source, f.bytes);
  }

private:
  struct FieldMemory {
    char *data;
    std::size_t bytes;
  };
  std::vector<FieldMemory> fields_;
  std::size_t record_bytes_ = 0;
};

/// Number of points for a rank, and the place of the first among all departures.
struct Portion {
  int count, start;
};

/// Packed departures grouped by destination rank.
struct Parcel {
  std::vector<PetscMPIInt> ranks;
  std::vector<Portion> portions;
  std::vector<char> records;
};

PetscErrorCode PackParcel(Points &from, const Departures &departures, Parcel *parcel)
{
  const std::size_t n = departures.points.size();
  std::vector<std::size_t> order(n);
  RecordCopier copier;
  PetscFunctionBeginUser;
  if (n == 0) PetscFunctionReturn(PETSC_SUCCESS);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return departures.ranks[a] < departures.ranks[b]; });
  PetscCall(RecordCopier::Create(from, &copier));
  parcel->records.resize(n * copier.RecordBytes());
  for (std::size_t k = 0; k < n; ++k) {
    const PetscMPIInt rank = departures.ranks[order[k]];
    if (parcel->ranks.empty() || parcel->ranks.back() != rank) {
      parcel->ranks.push_back(rank);
      parcel->portions.push_back({0, static_cast<int>(k)});
    }
    ++parcel->portions.back().count;
    copier.Pack(departures.points[order[k]], &parcel->records[k * copier.RecordBytes()]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode Points::Remove(const std::vector<int> &holes)
{
  int last = count_ - 1;
  std::size_t top = holes.size();
  RecordCopier copier;
  PetscFunctionBeginUser;
  if (holes.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RecordCopier::Create(*this, &copier));
  for (std::size_t k = 0; k < top; ++k) {
    while (top > k && holes[top - 1] == last) --top, --last;
    if (k >= top) break;
    copier.Copy(last--, holes[k]);
  }
  PetscCall(Resize(count_ - static_cast<int>(holes.size())));
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace
{

/// What comes from a rank.
struct Arrival {
  PetscMPIInt rank;
  Portion portion;
};

/// Tells every rank what comes to it. Collective.
PetscErrorCode AnnounceArrivals(MPI_Comm comm, const Parcel &parcel, std::vector<Arrival> *arrivals)
{
  PetscMPIInt sources, *ranks = nullptr;
  Portion *portions = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscCommBuildTwoSided(comm, 2, MPI_INT, static_cast<PetscMPIInt>(parcel.ranks.size()), parcel.ranks.data(),
                                   parcel.portions.data(), &sources, &ranks, static_cast<void *>(&portions)));
  for (PetscMPIInt k = 0; k < sources; ++k) arrivals->push_back({ranks[k], portions[k]});
  PetscCall(PetscFree(ranks));
  PetscCall(PetscFree(portions));
  std::sort(arrivals->begin(), arrivals->end(), [](const Arrival &a, const Arrival &b) { return a.rank < b.rank; });
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends packed points and adds the arrivals to `to`. Nothing is collective but the duplication of the communicator,
/// which counts tags and so must happen on all ranks.
PetscErrorCode Deliver(MPI_Comm comm, const Parcel &parcel, const std::vector<Arrival> &arrivals, Points &to)
{
  PetscMPIInt tag;
  MPI_Comm inner;
  RecordCopier copier;
  std::vector<MPI_Request> requests;
  MPI_Datatype record;
  int arriving = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscCommDuplicate(comm, &inner, &tag));
  for (const Arrival &arrival : arrivals) arriving += arrival.portion.count;
  const int before = to.Count();
  if (arriving > 0) PetscCall(to.Resize(before + arriving));
  PetscCall(RecordCopier::Create(to, &copier));
  const std::size_t bytes = copier.RecordBytes();
  std::vector<char> incoming(bytes * arriving);
  PetscCallMPI(MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &record));
  PetscCallMPI(MPI_Type_commit(&record));
  std::size_t offset = 0;
  for (const auto &[rank, portion] : arrivals) {
    PetscCallMPI(MPI_Irecv(&incoming[offset], portion.count, record, rank, tag, inner, &requests.emplace_back()));
    offset += bytes * portion.count;
  }
  for (std::size_t k = 0; k < parcel.ranks.size(); ++k)
    PetscCallMPI(MPI_Isend(&parcel.records[bytes * parcel.portions[k].start], parcel.portions[k].count, record, parcel.ranks[k],
                           tag, inner, &requests.emplace_back()));
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCallMPI(MPI_Type_free(&record));
  PetscCall(PetscCommDestroy(&inner));
  for (int k = 0; k < arriving; ++k) copier.Unpack(&incoming[bytes * k], before + k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode MovePoints(MPI_Comm comm, Points &from, Points &to, const Departures &departures)
{
  Parcel parcel;
  std::vector<Arrival> arrivals;
  PetscFunctionBeginUser;
  PetscCall(PackParcel(from, departures, &parcel));
  PetscCall(AnnounceArrivals(comm, parcel, &arrivals));
  PetscCall(from.Remove(departures.points));
  PetscCall(Deliver(comm, parcel, arrivals, to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyPoints(MPI_Comm comm, Points &from, Points &to, const Departures &departures,
                          std::vector<PetscSFNode> *origins)
{
  Parcel parcel;
  std::vector<Arrival> arrivals;
  PetscFunctionBeginUser;
  PetscCall(PackParcel(from, departures, &parcel));
  PetscCall(AnnounceArrivals(comm, parcel, &arrivals));
  PetscCall(Deliver(comm, parcel, arrivals, to));
  origins->clear();
  for (const auto &[rank, portion] : arrivals)
    for (int k = 0; k < portion.count; ++k) origins->push_back({rank, portion.start + k});
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
