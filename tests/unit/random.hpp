// Uniform random numbers for tests, the same in every run.
#pragma once

#include <random>

namespace mlgimp
{

/// Begins with a seed; Random(lower, upper) is a number between them.
class RandomNumbers : public std::mt19937
{
public:
  using std::mt19937::mt19937;
  using std::mt19937::operator();
  double operator()(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(*this); }
};

} // namespace mlgimp
