// Mutations of a DSLogic capture.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "fuzz/zip_mutator.hpp"

namespace biss::fuzz {

class DslMutator final : public ZipMutator {
 public:
  using ZipMutator::ZipMutator;

 private:
  std::size_t least_members() const override { return 3; }

  void new_members() override { members_ = unpack_zip(dsl_seed(random_()), most_samples); }

  void change_member(std::uint64_t kind) override {
    if (kind < 6) return change_header();
    if (kind < 8) return change_list();
    std::string& plane = text_of("L-");
    if (kind < 11) {
      plane = changed_bytes(std::move(plane), 8);
    } else if (!plane.empty()) {
      // A change comes a sample earlier or later.
      plane[below(plane.size())] ^= static_cast<char>(1U << below(8));
    }
  }

  void change_header() {
    static constexpr std::array<std::string_view, 18> words{"[version]",
                                                            "version = 2",
                                                            "version = 1",
                                                            "[header]",
                                                            "[header 2]",
                                                            "capturefile = L-0/0",
                                                            "device mode = 1",
                                                            "samplerate = 4 GHz",
                                                            "samplerate = 1 Hz",
                                                            "samplerate = 33.3 MHz",
                                                            "total samples = 18446744073709551615",
                                                            "total samples = 1000",
                                                            "total blocks = 2",
                                                            "total blocks = 0",
                                                            "probe0 = SLO",
                                                            "probe1 = MA",
                                                            "probe63 = x",
                                                            "\\s\\"};
    std::string& text = text_of("header");
    text = TokenMutator(std::move(text), "=\n", words, random_()).mutate();
  }

  void change_list() {
    const std::size_t at = below(members_.size());
    if (below(3) == 0) {
      members_.erase(members_.begin() + static_cast<std::ptrdiff_t>(at));
    } else {
      members_[at].name = "L-" + std::to_string(below(3)) + '/' + std::to_string(below(2));
    }
  }
};

}  // namespace biss::fuzz
