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

PetscErrorCode Points::Create(GeometryKind geometry, int loads, int history_components)
{
  static_assert(sizeof(PetscInt) == sizeof(int), "point fields of type kInt32 are stored as PetscInt");
  PetscFunctionBeginUser;
  table_ = PointFieldTable(geometry, loads, history_components);
  dim_ = table_[kPosition].components;
  PetscCall(DMCreate(PETSC_COMM_SELF, swarm_.Out()));
  PetscCall(DMSetType(swarm_, DMSWARM));
  PetscCall(DMSetDimension(swarm_, dim_));
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
             dim_,
             table_[kStress].components,
             table_[kShortWaveStress].components,
             static_cast<std::int64_t *>(first),
             real(kPosition),
             real(kVelocity),
             real(kDeformation),
             real(kStress),
             real(kShortWaveStress),
             real(kMass),
             real(kHalfSize),
             real(kInitialRadius),
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

/// Number of points for a rank, and the place of the first among all migrants.
struct BlockOfPoints {
  int count, start;
};

/// Packed migrants grouped by destination rank.
struct SendBuffer {
  std::vector<PetscMPIInt> ranks;
  std::vector<BlockOfPoints> blocks;
  std::vector<char> records;
};

PetscErrorCode Pack(Points &from, const Migrants &migrants, SendBuffer *buffer)
{
  const std::size_t n = migrants.points.size();
  std::vector<std::size_t> order(n);
  RecordCopier copier;
  PetscFunctionBeginUser;
  if (n == 0) PetscFunctionReturn(PETSC_SUCCESS);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return migrants.ranks[a] < migrants.ranks[b]; });
  PetscCall(RecordCopier::Create(from, &copier));
  buffer->records.resize(n * copier.RecordBytes());
  for (std::size_t k = 0; k < n; ++k) {
    const PetscMPIInt rank = migrants.ranks[order[k]];
    if (buffer->ranks.empty() || buffer->ranks.back() != rank) {
      buffer->ranks.push_back(rank);
      buffer->blocks.push_back({0, static_cast<int>(k)});
    }
    ++buffer->blocks.back().count;
    copier.Pack(migrants.points[order[k]], &buffer->records[k * copier.RecordBytes()]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode Points::Copy(int source, int target)
{
  RecordCopier copier;
  PetscFunctionBeginUser;
  PetscCall(RecordCopier::Create(*this, &copier));
  copier.Copy(source, target);
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
struct Incoming {
  PetscMPIInt rank;
  BlockOfPoints block;
};

/// Tells every rank what comes to it. Collective.
PetscErrorCode AnnounceIncoming(MPI_Comm comm, const SendBuffer &buffer, std::vector<Incoming> *incoming)
{
  PetscMPIInt sources, *ranks = nullptr;
  BlockOfPoints *blocks = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscCommBuildTwoSided(comm, 2, MPI_INT, static_cast<PetscMPIInt>(buffer.ranks.size()), buffer.ranks.data(),
                                   buffer.blocks.data(), &sources, &ranks, static_cast<void *>(&blocks)));
  for (PetscMPIInt k = 0; k < sources; ++k) incoming->push_back({ranks[k], blocks[k]});
  PetscCall(PetscFree(ranks));
  PetscCall(PetscFree(blocks));
  std::sort(incoming->begin(), incoming->end(), [](const Incoming &a, const Incoming &b) { return a.rank < b.rank; });
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends packed points and adds the incoming to `to`. Nothing is collective but the duplication of the communicator,
/// which counts tags and so must happen on all ranks.
PetscErrorCode Deliver(MPI_Comm comm, const SendBuffer &buffer, const std::vector<Incoming> &incoming, Points &to)
{
  PetscMPIInt tag;
  MPI_Comm inner;
  RecordCopier copier;
  std::vector<MPI_Request> requests;
  MPI_Datatype record;
  int arriving = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscCommDuplicate(comm, &inner, &tag));
  for (const Incoming &message : incoming) arriving += message.block.count;
  const int before = to.Count();
  if (arriving > 0) PetscCall(to.Resize(before + arriving));
  PetscCall(RecordCopier::Create(to, &copier));
  const std::size_t bytes = copier.RecordBytes();
  std::vector<char> received(bytes * arriving);
  PetscCallMPI(MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &record));
  PetscCallMPI(MPI_Type_commit(&record));
  std::size_t offset = 0;
  for (const auto &[rank, block] : incoming) {
    PetscCallMPI(MPI_Irecv(&received[offset], block.count, record, rank, tag, inner, &requests.emplace_back()));
    offset += bytes * block.count;
  }
  for (std::size_t k = 0; k < buffer.ranks.size(); ++k)
    PetscCallMPI(MPI_Isend(&buffer.records[bytes * buffer.blocks[k].start], buffer.blocks[k].count, record, buffer.ranks[k], tag,
                           inner, &requests.emplace_back()));
  PetscCallMPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  PetscCallMPI(MPI_Type_free(&record));
  PetscCall(PetscCommDestroy(&inner));
  for (int k = 0; k < arriving; ++k) copier.Unpack(&received[bytes * k], before + k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace

PetscErrorCode MovePoints(MPI_Comm comm, Points &from, Points &to, const Migrants &migrants)
{
  SendBuffer buffer;
  std::vector<Incoming> incoming;
  PetscFunctionBeginUser;
  PetscCall(Pack(from, migrants, &buffer));
  PetscCall(AnnounceIncoming(comm, buffer, &incoming));
  PetscCall(from.Remove(migrants.points));
  PetscCall(Deliver(comm, buffer, incoming, to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CopyPoints(MPI_Comm comm, Points &from, Points &to, const Migrants &migrants, std::vector<PetscSFNode> *origins)
{
  SendBuffer buffer;
  std::vector<Incoming> incoming;
  PetscFunctionBeginUser;
  PetscCall(Pack(from, migrants, &buffer));
  PetscCall(AnnounceIncoming(comm, buffer, &incoming));
  PetscCall(Deliver(comm, buffer, incoming, to));
  origins->clear();
  for (const auto &[rank, block] : incoming)
    for (int k = 0; k < block.count; ++k) origins->push_back({rank, block.start + k});
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
