// One simulated line in every container, read through the flow of pieces and edge by edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "capture/samples.hpp"
#include "sim/line_setup.hpp"
#include "wire/edge.hpp"

namespace biss::flow_trial {

/// A line with a kind of fault in some of its cycles, drawn from the number.
struct Trial {
  explicit Trial(std::uint64_t number);

  sim::LineSetup setup;
  Hertz sample_rate;
  std::vector<wire::Edge> edges;
  Picoseconds end;
};

/// A capture file.
struct Container {
  std::string name;
  std::string bytes;
};

/// Containers of changes; containers of samples are `sampled_containers`.
std::vector<Container> change_containers(const Trial& trial);
std::vector<Container> sampled_containers(const Trial& trial);

/// Every cycle as text. \param piece_bytes as OpenOptions::piece_bytes
std::vector<std::string> by_edges(const Trial& trial, const Container& container);
std::vector<std::string> by_flow(const Trial& trial, const Container& container, unsigned threads,
                                 std::size_t piece_bytes);

}  // namespace biss::flow_trial
