// HDF5 through its C interface.
#include "program/system/hdf5_file.hpp"

#include "program/system/agree.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <sys/mman.h>

namespace mlgimp
{

// ROMIO, MPI's layer for files, writes pieces together with the gaps between them, which it must lock for that; where a file
// system has no locks it ends the run. By this hint it writes the pieces alone.
static constexpr char kHint[] = "romio_ds_write", kHintValue[] = "disable";

/// The hint for files that PETSc's viewers write, which take none from us: ROMIO looks for a file of hints. This one is in
/// memory, and stays open for as long as the program runs.
static void HintPetsc()
{
  const int hints = memfd_create("romio_hints", 0);
  if (hints >= 0 && WriteAll(hints, std::string(kHint) + " " + kHintValue + "\n"))
    setenv("ROMIO_HINTS", ("/proc/self/fd/" + std::to_string(hints)).c_str(), 0);
}

void PrepareHdf5()
{
  H5dont_atexit(); // a file whose closing has failed would be closed again at exit, with a crash; all others are closed by then
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  setenv("HDF5_USE_FILE_LOCKING", "FALSE", 0); // a file with its final name is whole, and our own lock is in the folder
  setenv("OMPI_MCA_io_ompio_priority", "0", 0);
  HintPetsc();
}

void DoWithoutLocks() { setenv("ROMIO_FSTYPE_FORCE", "ufs:", 0); }

Slab MakeSlab(MPI_Comm comm, int count)
{
  unsigned long long mine = static_cast<unsigned long long>(count), before = 0, total = 0;
  MPI_Exscan(&mine, &before, 1, MPI_UNSIGNED_LONG_LONG, MPI_SUM, comm);
  MPI_Allreduce(&mine, &total, 1, MPI_UNSIGNED_LONG_LONG, MPI_SUM, comm);
  return {RankIn(comm) ? before : 0, mine, total};
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
void H5Writer::RecordSystem(bool success)
{
  if (!success && good_) error_ = errno;
  Record(success);
}

/// A failure of one rank becomes that of all, so that none waits for the others in a collective call.
void H5Writer::AgreeOnError(const char *place) { good_ = Agree(comm_, place, good_ ? "" : "failed").empty(); }

/// Makes sure of room for the first `size` bytes of the file, and for what the library adds to them.
void H5Writer::Reserve(off_t size)
{
  constexpr off_t kOverhead = 1 << 16; // size: bytes for names and attributes
  if (good_ && part_.Valid()) {
    const off_t end = size + kOverhead;
    const int error = end > reserved_ ? posix_fallocate(part_, reserved_, end - reserved_) : 0;
    reserved_ = std::max(reserved_, end);
    errno = error;
    RecordSystem(error == 0);
  }
  AgreeOnError("file_room");
}

void H5Writer::Open(MPI_Comm comm, const std::string &path, bool checked)
{
  comm_ = comm;
  path_ = path;
  checked_ = checked;
  chunks_ = 0;
  if (RankIn(comm) == 0) {
    part_ = Descriptor(open((path + ".part").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), close);
    RecordSystem(part_.Valid());
  }
  Reserve(0);
  if (!good_) return;
  const H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  MPI_Info hints;
  MPI_Info_create(&hints);
  MPI_Info_set(hints, kHint, kHintValue);
  H5Pset_fapl_mpio(access, comm, hints);
  MPI_Info_free(&hints);
  if (checked) H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110); // the first format that sums all metadata
  file_ = H5Handle(H5Fcreate((path + ".part").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
  Record(file_.Valid());
  reserved_ = 0; // the file was emptied
  Reserve(0);
}

void H5Writer::Group(const std::string &name)
{
  if (!good_) return;
  const H5Handle group(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  Record(group.Valid());
  AgreeOnError("file_group");
}

void H5Writer::Attribute(const std::string &object, const std::string &name, const std::vector<double> &values)
{
  const hsize_t size = values.size();
  if (!good_) return;
  const H5Handle space(size == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), H5Sclose);
  const H5Handle attribute(
      H5Acreate_by_name(file_, object.c_str(), name.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  Record(attribute.Valid() && H5Awrite(attribute, H5T_NATIVE_DOUBLE, values.data()) >= 0);
  AgreeOnError("file_attribute");
}

/// How a dataset lies in the file: checksums need chunks; those are equal and of about a megabyte.
H5Handle H5Writer::Layout(int components, hsize_t rows, std::size_t row_size) const
{
  constexpr hsize_t kChunk = 1 << 20; // size
  H5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (!checked_ || rows == 0) return layout;
  const hsize_t chunks = (rows * row_size + kChunk - 1) / kChunk;
  const hsize_t size[2] = {(rows + chunks - 1) / chunks, static_cast<hsize_t>(components)};
  H5Pset_chunk(layout, components > 1 ? 2 : 1, size);
  H5Pset_fletcher32(layout);
  return layout;
}

/// Room for a dataset's chunks, which come after those of all others. They are filled when the dataset is created.
void H5Writer::ReserveChunks(hsize_t bytes)
{
  chunks_ += static_cast<off_t>(bytes + bytes / 64);
  Reserve(chunks_);
}

void H5Writer::Dataset(const std::string &name, hid_t type, int components, const Slab &slab, const void *data)
{
  const std::size_t row_size = static_cast<std::size_t>(components) * H5Tget_size(type);
  if (good_ && checked_) ReserveChunks(slab.total * row_size);
  if (!good_) return;
  const H5Handle layout = Layout(components, slab.total, row_size), transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  const H5Handle target = SlabSpace(components, slab, false), source = SlabSpace(components, slab, true);
  const H5Handle set(H5Dcreate2(file_, name.c_str(), type, target, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose);
  Record(set.Valid());
  Reserve(good_ && !checked_ ? static_cast<off_t>(H5Dget_offset(set) + H5Dget_storage_size(set)) : 0);
  if (!good_ || slab.total == 0) return;
  H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  Record(H5Dwrite(set, type, source, target, transfer, data) >= 0);
  AgreeOnError("file_dataset");
}

void H5Writer::List(const std::string &name, const std::vector<double> &values)
{
  Dataset(name, H5T_NATIVE_DOUBLE, 1, MakeSlab(comm_, static_cast<int>(values.size())), values.data());
}

void H5Writer::Text(const std::string &name, const std::string &text)
{
  Dataset(name, H5T_NATIVE_UINT8, 1, MakeSlab(comm_, static_cast<int>(text.size())), text.data());
}

std::string H5Writer::Finish()
{
  const std::string part = path_ + ".part";
  if (!good_ && part_.Valid()) Record(ftruncate(part_, 0) == 0); // frees what the library needs to close a file
  MPI_Barrier(comm_);
  Record(file_.Close());
  AgreeOnError("file_close");
  return OnFirstRank(comm_, "file_name", [&]() -> std::string {
    if (good_) RecordSystem(part_.Close() && std::rename(part.c_str(), path_.c_str()) == 0);
    if (good_) return "";
    unlink(part.c_str());
    return CannotWrite(path_, error_);
  });
}

bool H5Reader::IsWholeGroup(const std::string &group) const
{
#if H5_VERSION_GE(1, 12, 0)
  H5O_native_info_t sizes;
  return H5Oget_native_info_by_name(file_, group.c_str(), &sizes, H5O_NATIVE_INFO_ALL, H5P_DEFAULT) >= 0;
#else
  H5O_info_t sizes;
  return H5Oget_info_by_name(file_, group.c_str(), &sizes, H5P_DEFAULT) >= 0;
#endif
}

bool H5Reader::Open(const std::string &path)
{
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false; // a pipe would be waited for
  file_ = H5Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  return file_.Valid();
}

bool H5Reader::Attribute(const std::string &object, const std::string &name, std::vector<double> *values) const
{
  if (H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) <= 0) return false;
  const H5Handle attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.Valid()) return false;
  const H5Handle space(H5Aget_space(attribute), H5Sclose), type(H5Aget_type(attribute), H5Tclose);
  return H5Sget_simple_extent_npoints(space) == static_cast<hssize_t>(values->size()) && H5Tget_class(type) == H5T_FLOAT &&
         H5Aread(attribute, H5T_NATIVE_DOUBLE, values->data()) >= 0;
}

bool H5Reader::Rows(const std::string &name, hid_t type, int components, hsize_t *rows) const
{
  hsize_t size[2] = {0, 1};
  if (H5Lexists(file_, name.c_str(), H5P_DEFAULT) <= 0) return false;
  const H5Handle set(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.Valid()) return false;
  const H5Handle space(H5Dget_space(set), H5Sclose), stored(H5Dget_type(set), H5Tclose);
  if (H5Sget_simple_extent_ndims(space) != (components > 1 ? 2 : 1)) return false;
  H5Sget_simple_extent_dims(space, size, nullptr);
  const hsize_t bytes = H5Tget_size(type) * static_cast<hsize_t>(components), room = H5Dget_storage_size(set);
  *rows = size[0];
  return H5Tget_class(stored) == H5Tget_class(type) && H5Tget_size(stored) == H5Tget_size(type) &&
         size[1] == static_cast<hsize_t>(components) && size[0] <= room / bytes;
}

bool H5Reader::Dataset(const std::string &name, hid_t type, int components, const Slab &slab, void *data) const
{
  hsize_t rows = 0;
  if (!Rows(name, type, components, &rows) || rows != slab.total) return false;
  if (slab.count == 0) return true;
  const H5Handle set(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  const H5Handle source = SlabSpace(components, slab, false), target = SlabSpace(components, slab, true);
  return H5Dread(set, type, target, source, H5P_DEFAULT, data) >= 0;
}

bool H5Reader::List(const std::string &name, std::vector<double> *values) const
{
  hsize_t rows = 0;
  if (!Rows(name, H5T_NATIVE_DOUBLE, 1, &rows)) return false;
  values->resize(rows);
  return Dataset(name, H5T_NATIVE_DOUBLE, 1, {0, rows, rows}, values->data());
}

bool H5Reader::Text(const std::string &name, std::string *text) const
{
  hsize_t rows = 0;
  if (!Rows(name, H5T_NATIVE_UINT8, 1, &rows)) return false;
  text->resize(rows);
  return Dataset(name, H5T_NATIVE_UINT8, 1, {0, rows, rows}, text->data());
}

} // namespace mlgimp
