// Owning handles for PETSc objects: destroyed with their scope, moved but never copied.
#pragma once

#include "base/petsc.hpp"

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
