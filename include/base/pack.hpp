// Four doubles that load, multiply, add and store as one vector register where the machine has it.
#pragma once

namespace mlgimp
{

typedef double Pack __attribute__((vector_size(32)));
typedef double UnalignedPack __attribute__((vector_size(32), aligned(8)));

inline Pack LoadPack(const double *x) { return *reinterpret_cast<const UnalignedPack *>(x); }
inline void StorePack(double *x, Pack value) { *reinterpret_cast<UnalignedPack *>(x) = value; }
inline void AddPack(double *x, Pack value) { StorePack(x, LoadPack(x) + value); }

} // namespace mlgimp
