// States that checkpoints keep as lists of numbers: a state's Members ties those of its members, in the order of the file.
#pragma once

#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace mlgimp
{

template <class State>
inline constexpr std::size_t kNumbersOf = std::tuple_size_v<decltype(State::Members(std::declval<State &>()))>;

template <class State> std::vector<double> ToNumbers(const State &state)
{
  return std::apply([](auto... x) { return std::vector<double>{static_cast<double>(x)...}; }, State::Members(state));
}

/// numbers [kNumbersOf], which must have been found sensible.
template <class State> State FromNumbers(const double *numbers)
{
  State state;
  std::apply([&](auto &...x) { ((x = static_cast<std::decay_t<decltype(x)>>(*numbers++)), ...); }, State::Members(state));
  return state;
}

} // namespace mlgimp
