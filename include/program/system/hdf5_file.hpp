// An HDF5 file: groups, attributes, and datasets that each rank holds a slab of. Written in parallel; read by each rank alone.
//
// Files are written under another name and renamed when they are complete, so that a file with its final name is whole.
// Room on the disk is reserved before MPI writes: MPI libraries do not return from a full disk on every rank, and hide why.
#pragma once

#include "base/petsc.hpp"
#include "physics/point_fields.hpp"
#include "program/system/files.hpp"

#include <hdf5.h>

#include <string>
#include <vector>

namespace mlgimp
{

/// The native type of a point field's numbers.
inline hid_t H5Type(FieldType type)
{
  return type == FieldType::kReal ? H5T_NATIVE_DOUBLE : type == FieldType::kInt32 ? H5T_NATIVE_INT : H5T_NATIVE_INT64;
}

/// Call before MPI_Init. Leaves the words about errors to us, and asks HDF5 and MPI for no locks: not all file systems have them.
/// Makes Open MPI prefer ROMIO, where it has it, to its own layer for files (ompio): that one guards shared file pointers, which
/// are not used here, by a semaphore named after the file, without the folder, that a killed run leaves locked for ever. What the
/// user has chosen in the environment stays.
void PrepareHdf5();

/// Where a file system is known to have no locks: what ROMIO has for NFS locks all that it does, and its way for any Unix does
/// not. Call before files are opened.
void DoWithoutLocks();

using H5Handle = Owned<hid_t>;

/// Where a rank's rows lie in a dataset.
struct Slab {
  hsize_t start, count, total;
};

/// This rank's `count` rows among those of all ranks. Collective.
Slab MakeSlab(MPI_Comm comm, int count);

/// Writes one file. After any failure, on whatever rank, further calls do nothing, and Finish returns the error.
class H5Writer
{
public:
  /// Starts path + ".part". checked: with HDF5's checksums of all metadata and data, for files that are read back; such files
  /// need HDF5 1.10 or later. Collective, like all members.
  void Open(MPI_Comm comm, const std::string &path, bool checked);
  void Group(const std::string &name);
  /// A few numbers; one of them is a scalar.
  void Attribute(const std::string &object, const std::string &name, const std::vector<double> &values);
  /// Rows of `components` values; one component gives a dataset of rank 1.
  void Dataset(const std::string &name, hid_t type, int components, const Slab &slab, const void *data);
  /// A dataset of any length that one rank holds and the others give empty.
  void List(const std::string &name, const std::vector<double> &values);
  void Text(const std::string &name, const std::string &text);
  /// Closes and renames. Empty, or why there is no such file, the same on every rank.
  std::string Finish();

private:
  void Record(bool success) { good_ = good_ && success; }
  void RecordSystem(bool success);
  void AgreeOnError(const char *place);
  void Reserve(off_t size);
  H5Handle Layout(int components, hsize_t rows, std::size_t row_size) const;
  void ReserveChunks(hsize_t bytes);

  MPI_Comm comm_ = MPI_COMM_NULL;
  std::string path_;
  H5Handle file_;
  Descriptor part_;    ///< the same file on the first rank, by which room is reserved
  off_t reserved_ = 0; ///< bytes
  off_t chunks_ = 0;   ///< bytes of all chunks, with some more for what they are found by
  bool checked_ = false, good_ = true;
  int error_ = 0; ///< errno of the first call of the system that failed
};

/// Reads one file on this rank alone, without MPI, so that no damage that one rank meets keeps the others waiting. Every
/// function returns false where what it asks for is not there, not of the right kind, or damaged.
class H5Reader
{
public:
  bool Open(const std::string &path);
  bool Has(const std::string &name) const { return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0; }
  /// Whether all blocks of a group's index can be read, also those that no name needs.
  bool IsWholeGroup(const std::string &group) const;
  /// As many numbers as `values` has.
  bool Attribute(const std::string &object, const std::string &name, std::vector<double> *values) const;
  /// Rows of a dataset of values of this type; what is not all in the file is not there.
  bool Rows(const std::string &name, hid_t type, int components, hsize_t *rows) const;
  bool Dataset(const std::string &name, hid_t type, int components, const Slab &slab, void *data) const;
  bool List(const std::string &name, std::vector<double> *values) const;
  bool Text(const std::string &name, std::string *text) const;

private:
  H5Handle file_;
};

} // namespace mlgimp
