// Owning handles for objects of PETSc and MPI: destroyed with their scope, never copied.
#pragma once

#include "base/petsc.hpp"

#include <array>
#include <tuple>
#include <utility>

namespace mlgimp
{

/// Owns one PETSc object of type T; `Out()` hands the address of an empty handle to a Create function.
template <class T, PetscErrorCode (*Destroy)(T *)> class Handle
{
public:
  Handle() = default;
  Handle(Handle &&other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  /// The other handle takes the object that this one had, and destroys it at its own end.
  Handle &operator=(Handle &&other) noexcept
  {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Handle() { Reset(); }

  operator T() const { return object_; }
  PetscObject Object() const { return reinterpret_cast<PetscObject>(object_); }
  T *Out()
  {
    Reset();
    return &object_;
  }

  void Reset()
  {
    PetscFunctionBegin;
    PetscCallVoid(Destroy(&object_));
    PetscFunctionReturnVoid();
  }

private:
  T object_ = nullptr;
};

using DMHandle = Handle<DM, DMDestroy>;
using VecHandle = Handle<Vec, VecDestroy>;
using MatHandle = Handle<Mat, MatDestroy>;
using KSPHandle = Handle<KSP, KSPDestroy>;
using SFHandle = Handle<PetscSF, PetscSFDestroy>;

/// Calls work(numbers, ...) with this rank's numbers of some vectors, and gives them back.
template <std::size_t count, class Work> PetscErrorCode WithNumbers(const Vec (&vectors)[count], Work work)
{
  std::array<PetscScalar *, count> numbers;
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < count; ++k) PetscCall(VecGetArray(vectors[k], &numbers[k]));
  std::apply(work, numbers);
  for (std::size_t k = 0; k < count; ++k) PetscCall(VecRestoreArray(vectors[k], &numbers[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Owns an object of MPI, null at first; `Out()` hands the address of an empty handle to a function that makes one.
template <class T, int (*Free)(T *)> class MpiHandle
{
public:
  explicit MpiHandle(T null) : null_(null), object_(null) {}
  MpiHandle(const MpiHandle &) = delete;
  MpiHandle &operator=(const MpiHandle &) = delete;
  ~MpiHandle() { Reset(); }

  operator T() const { return object_; }
  T *Out()
  {
    Reset();
    return &object_;
  }

private:
  void Reset()
  {
    if (object_ != null_) Free(&object_);
  }

  const T null_;
  T object_;
};

/// Owns a communicator.
struct CommHandle : MpiHandle<MPI_Comm, MPI_Comm_free> {
  CommHandle() : MpiHandle(MPI_COMM_NULL) {}
};

/// Owns an MPI type of some doubles in a row.
struct UnitHandle : MpiHandle<MPI_Datatype, MPI_Type_free> {
  UnitHandle() : MpiHandle(MPI_DATATYPE_NULL) {}
  PetscErrorCode Create(int doubles)
  {
    PetscFunctionBeginUser;
    MPI_Datatype *const type = Out();
    PetscCallMPI(MPI_Type_contiguous(doubles, MPI_DOUBLE, type));
    PetscCallMPI(MPI_Type_commit(type));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

} // namespace mlgimp
