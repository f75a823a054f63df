// Owning handles for PETSc objects: destroyed with their scope, moved but never copied.
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

/// Owns an MPI type of some doubles in a row.
class UnitHandle
{
public:
  UnitHandle() = default;
  UnitHandle(const UnitHandle &) = delete;
  UnitHandle &operator=(const UnitHandle &) = delete;
  ~UnitHandle() { Free(); }

  operator MPI_Datatype() const { return type_; }
  PetscErrorCode Create(int doubles)
  {
    PetscFunctionBeginUser;
    Free();
    PetscCallMPI(MPI_Type_contiguous(doubles, MPI_DOUBLE, &type_));
    PetscCallMPI(MPI_Type_commit(&type_));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

private:
  void Free()
  {
    if (type_ != MPI_DATATYPE_NULL) MPI_Type_free(&type_);
  }

  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

} // namespace mlgimp
