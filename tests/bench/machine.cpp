// What one core of this machine can do at most: memory bandwidth, multiply-add rate and clock, the yardsticks of `make bench`.
//
// Prints one line: GB/s of a triad over arrays much larger than the caches, Gflop/s of fused multiply-adds, and GHz.
#include "base/pack.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

using namespace mlgimp;

namespace
{

constexpr int kRepetitions = 5;

/// Shortest time of several calls, s.
template <class Work> double ShortestTime(Work work)
{
  double shortest = 1e30;
  for (int n = 0; n < kRepetitions; ++n) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    shortest = std::min(shortest, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return shortest;
}

/// a = b + s c: three arrays of eight bytes an entry pass.
double TriadBandwidth()
{
  constexpr std::size_t kCount = 8000000;
  std::vector<double> a(kCount, 1.0), b(kCount, 2.0), c(kCount, 3.0);
  double s = 0.5;
  const double time = ShortestTime([&] {
    for (std::size_t k = 0; k < kCount; ++k) a[k] = b[k] + s * c[k];
    s += a[kCount / 2] * 1e-9; // the next sweep depends on this one
  });
  return 3 * 8.0 * kCount / time;
}

/// Twelve independent chains hide the latency of a multiply-add.
double MultiplyAddRate()
{
  constexpr int kChains = 12, kLinks = 4000000;
  volatile double factor = 0.999999, shift = 1e-6; // values that the compiler cannot know
  const double f = factor, s = shift;
  const double time = ShortestTime([&] {
    Pack x[kChains], sum{};
#pragma GCC unroll 12
    for (int k = 0; k < kChains; ++k) x[k] = Pack{1.0, 2.0, 3.0, 4.0} + static_cast<double>(k);
    for (int n = 0; n < kLinks; ++n)
#pragma GCC unroll 12
      for (int k = 0; k < kChains; ++k) x[k] = x[k] * f + s;
#pragma GCC unroll 12
    for (int k = 0; k < kChains; ++k) sum += x[k];
    factor = sum[0] + sum[1] + sum[2] + sum[3]; // keeps the loop
  });
  return 8.0 * kChains * kLinks / time;
}

/// Cycles a second: sums of integers that wait for each other take one cycle each.
double Clock()
{
  constexpr int kCount = 20000000, kInOne = 8;
  volatile long one = 1;
  long sum = 0;
  const long step = one;
  const double time = ShortestTime([&] {
    for (int n = 0; n < kCount; ++n)
#pragma GCC unroll 8
      for (int k = 0; k < kInOne; ++k) {
        sum += step;
        __asm__ volatile("" : "+r"(sum)); // keeps the sums apart
      }
  });
  one = sum;
  return 1.0 * kInOne * kCount / time;
}

} // namespace

int main()
{
  std::printf("%.3f %.3f %.3f\n", 1e-9 * TriadBandwidth(), 1e-9 * MultiplyAddRate(), 1e-9 * Clock());
  return 0;
}
