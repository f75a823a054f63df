// Parallel HDF5 through its C interface.
#include "program/hdf5_file.hpp"

#include "program/seal.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>

namespace mlgimp
{

void AvoidSharedFilePointers() { setenv("OMPI_MCA_io_ompio_priority", "0", 0); }

/// Bytes that the system gets at a time. For more Linux takes large pages that nobody has used for long, and which a virtual
/// machine must then get from its host: ten times slower.
static constexpr std::size_t kPiece = 1 << 16;

static H5Handle ParallelAccess(MPI_Comm comm)
{
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); // errors are told in our own words
  H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_mpio(access, comm, MPI_INFO_NULL);
  return access;
}

static H5Handle CollectiveTransfer()
{
  H5Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  return transfer;
}

static H5Handle SlabSpace(int components, const Slab &slab, bool memory)
{
  const int rank = components > 1 ? 2 : 1;
  const hsize_t width = static_cast<hsize_t>(components);
  const hsize_t size[2] = {memory ? slab.count : slab.total, width}, start[2] = {memory ? 0 : slab.start, 0};
  const hsize_t count[2] = {slab.count, width};
  H5Handle space(H5Screate_simple(rank, size, nullptr), H5Sclose);
  if (slab.count == 0)
    H5Sselect_none(space);
  else
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
  return space;
}

/// What a call of the system on the first rank returned.
void H5Writer::NoteSystem(bool success)
{
  if (!success && good_) error_ = errno;
  Note(success);
}

/// A failure of one rank becomes that of all, so that none waits for the others in a collective call.
void H5Writer::Agree()
{
  int good = good_;
  MPI_Allreduce(MPI_IN_PLACE, &good, 1, MPI_INT, MPI_MIN, comm_);
  good_ = good;
}

/// Makes sure of room for the first `size` bytes of the file, and for what the library adds to them.
void H5Writer::Reserve(off_t size)
{
  constexpr off_t kOverhead = 1 << 16; // bytes for names, attributes and the seal
  if (good_ && part_.Valid()) {
    const off_t end = size + kOverhead;
    const int error = end > reserved_ ? posix_fallocate(part_, reserved_, end - reserved_) : 0;
    reserved_ = std::max(reserved_, end);
    errno = error;
    NoteSystem(error == 0);
  }
  Agree();
}

PetscErrorCode H5Writer::Open(MPI_Comm comm, const std::string &path)
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  comm_ = comm;
  path_ = path;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    part_.Reset(open((path + ".part").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666));
    NoteSystem(part_.Valid());
  }
  Reserve(0);
  if (!good_) PetscFunctionReturn(PETSC_SUCCESS);
  const H5Handle access = ParallelAccess(comm);
  file_ = H5Handle(H5Fcreate((path + ".part").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
  Note(file_.Valid());
  reserved_ = 0; // the file was emptied
  Reserve(0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void H5Writer::Group(const std::string &name)
{
  if (!good_) return;
  const H5Handle group(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  Note(group.Valid());
}

void H5Writer::WriteAttribute(const std::string &object, const std::string &name, hid_t type, hid_t space, const void *data)
{
  if (!good_) return;
  const H5Handle attribute(
      H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  Note(attribute.Valid() && H5Awrite(attribute, type, data) >= 0);
}

void H5Writer::Attribute(const std::string &object, const std::string &name, double value)
{
  const H5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  WriteAttribute(object, name, H5T_NATIVE_DOUBLE, space, &value);
}

void H5Writer::Attribute(const std::string &object, const std::string &name, const std::string &value)
{
  const H5Handle space(H5Screate(H5S_SCALAR), H5Sclose), type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, value.size() + 1);
  WriteAttribute(object, name, type, space, value.c_str());
}

void H5Writer::Attribute(const std::string &object, const std::string &name, const std::vector<double> &values)
{
  const hsize_t size = values.size();
  const H5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  WriteAttribute(object, name, H5T_NATIVE_DOUBLE, space, values.data());
}

void H5Writer::Dataset(const std::string &name, hid_t type, int components, const Slab &slab, const void *data)
{
  if (!good_) return;
  const H5Handle space = SlabSpace(components, slab, false);
  const H5Handle set(H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
  Note(set.Valid());
  if (slab.total == 0) return;
  Reserve(good_ ? static_cast<off_t>(H5Dget_offset(set) + H5Dget_storage_size(set)) : 0);
  const std::size_t row = components * H5Tget_size(type), rows = std::max<std::size_t>(1, kPiece / row);
  for (hsize_t first = 0; first < slab.count && good_; first += rows) {
    const Slab piece = {slab.start + first, std::min<hsize_t>(rows, slab.count - first), slab.total};
    const H5Handle target = SlabSpace(components, piece, false), source = SlabSpace(components, piece, true);
    Note(H5Dwrite(set, type, source, target, H5P_DEFAULT, static_cast<const char *>(data) + first * row) >= 0);
  }
  Agree();
}

PetscErrorCode H5Writer::Finish(bool sealed, std::string *problem)
{
  PetscMPIInt rank;
  const std::string part = path_ + ".part";
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm_, &rank));
  Agree();
  if (!good_ && part_.Valid()) Note(ftruncate(part_, 0) == 0); // frees what the library needs to close a file
  PetscCallMPI(MPI_Barrier(comm_));
  Note(file_.Close());
  Agree();
  if (rank == 0) {
    if (good_) NoteSystem(part_.Close() && (!sealed || Seal(part)) && std::rename(part.c_str(), path_.c_str()) == 0);
    if (!good_) unlink(part.c_str());
    *problem = good_ ? "" : CannotWrite(path_, error_);
  }
  PetscCall(ShareText(comm_, problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool H5Reader::Open(MPI_Comm comm, const std::string &path)
{
  int rank = 0, is_file = 0;
  MPI_Comm_rank(comm, &rank);
  if (rank == 0) {
    std::error_code error;
    is_file = std::filesystem::is_regular_file(path, error);
  }
  MPI_Bcast(&is_file, 1, MPI_INT, 0, comm);
  if (!is_file) return false;
  const H5Handle access = ParallelAccess(comm);
  file_ = H5Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
  return file_.Valid();
}

H5Handle H5Reader::OpenAttribute(const std::string &object, const std::string &name) const
{
  if (H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) <= 0) return H5Handle();
  return H5Handle(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
}

bool H5Reader::Attribute(const std::string &object, const std::string &name, double *value) const
{
  std::vector<double> values;
  if (!Attribute(object, name, &values) || values.size() != 1) return false;
  *value = values[0];
  return true;
}

bool H5Reader::Attribute(const std::string &object, const std::string &name, std::string *value) const
{
  const H5Handle attribute = OpenAttribute(object, name);
  if (!attribute.Valid()) return false;
  const H5Handle type(H5Aget_type(attribute), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING) return false;
  std::vector<char> text(H5Tget_size(type) + 1, '\0');
  if (H5Aread(attribute, type, text.data()) < 0) return false;
  *value = text.data();
  return true;
}

bool H5Reader::Attribute(const std::string &object, const std::string &name, std::vector<double> *values) const
{
  const H5Handle attribute = OpenAttribute(object, name);
  if (!attribute.Valid()) return false;
  const H5Handle space(H5Aget_space(attribute), H5Sclose);
  values->resize(static_cast<std::size_t>(std::max<hssize_t>(H5Sget_simple_extent_npoints(space), 0)));
  return H5Aread(attribute, H5T_NATIVE_DOUBLE, values->data()) >= 0;
}

bool H5Reader::Rows(const std::string &name, hsize_t *rows) const
{
  const H5Handle set(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.Valid()) return false;
  const H5Handle space(H5Dget_space(set), H5Sclose);
  hsize_t size[2] = {0, 0};
  if (H5Sget_simple_extent_ndims(space) > 2 || H5Sget_simple_extent_dims(space, size, nullptr) < 1) return false;
  *rows = size[0];
  return true;
}

bool H5Reader::Dataset(const std::string &name, hid_t type, int components, const Slab &slab, void *data) const
{
  const H5Handle set(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  hsize_t size[2] = {0, 1};
  if (!set.Valid()) return false;
  const H5Handle space(H5Dget_space(set), H5Sclose);
  if (H5Sget_simple_extent_ndims(space) != (components > 1 ? 2 : 1)) return false;
  H5Sget_simple_extent_dims(space, size, nullptr);
  if (size[0] != slab.total || size[1] != static_cast<hsize_t>(components)) return false;
  if (slab.total == 0) return true;
  const H5Handle file_space = SlabSpace(components, slab, false), memory_space = SlabSpace(components, slab, true);
  return H5Dread(set, type, memory_space, file_space, CollectiveTransfer(), data) >= 0;
}

} // namespace mlgimp
