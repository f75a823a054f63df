// Four doubles that load, multiply, add and store as one vector register where the machine has it.
#pragma once

namespace mlgimp
{

typedef double Pack __attribute__((vector_size(32)));
typedef double UnalignedPack __attribute__((vector_size(32), aligned(8)));

inline Pack Load(const double *x) { return *reinterpret_cast<const UnalignedPack *>(x); }
inline void Store(double *x, Pack value) { *reinterpret_cast<UnalignedPack *>(x) = value; }

} // namespace mlgimp
