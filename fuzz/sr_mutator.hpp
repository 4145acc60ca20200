// Mutations of a sigrok session.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "capture/sr.hpp"
#include "fuzz/zip_mutator.hpp"

namespace biss::fuzz {

class SrMutator final : public ZipMutator {
 public:
  using ZipMutator::ZipMutator;

 private:
  std::size_t least_members() const override { return 3; }

  void new_members() override {
    const std::uint64_t seed = random_();
    members_ = {{"version", "2"},
                {"metadata", capture::sr_metadata_text(sampled_layout(seed))},
                {"logic-1-1", raw_seed(seed)}};
  }

  void change_member(std::uint64_t kind) override {
    if (kind < 6) return change_metadata();
    if (kind < 8) return cut_chunks();
    if (kind == 8) return change_list();
    std::string& samples = text_of("logic");
    if (kind < 11) {
      samples = changed_bytes(std::move(samples), 64);
    } else {
      move_change(samples);
    }
  }

  void change_metadata() {
    static constexpr std::array<std::string_view, 20> words{"[device 1]",
                                                            "[device 2]",
                                                            "[global]",
                                                            "capturefile=logic-1",
                                                            "capturefile=version",
                                                            "unitsize=2",
                                                            "unitsize=8",
                                                            "unitsize=9",
                                                            "samplerate=0",
                                                            "samplerate=4 GHz",
                                                            "samplerate=1 Hz",
                                                            "samplerate=33.3 MHz",
                                                            "probe1=SLO",
                                                            "probe8=MA",
                                                            "probe64=x",
                                                            "probe0=x",
                                                            "total probes=99",
                                                            "=",
                                                            "\\s\\n\\",
                                                            "analog3=A"};
    std::string& text = text_of("metadata");
    text = TokenMutator(std::move(text), "=\n", words, random_()).mutate();
  }

  // Splits the samples into other chunks, or joins them in one member.
  void cut_chunks() {
    std::string all;
    std::erase_if(members_, [&](const ZipText& member) {
      if (!member.name.starts_with("logic")) return false;
      all += member.text;
      return true;
    });
    const std::size_t chunks = below(5);
    if (chunks == 0) members_.push_back({"logic-1", all});
    for (std::size_t chunk = 1; chunk <= chunks; ++chunk) {
      const std::size_t size = chunk == chunks ? all.size() : below(all.size() + 1);
      members_.push_back({"logic-1-" + std::to_string(chunk), all.substr(0, size)});
      all.erase(0, size);
    }
  }

  void change_list() {
    const std::size_t at = below(members_.size());
    switch (below(3)) {
      case 0:
        members_.erase(members_.begin() + static_cast<std::ptrdiff_t>(at));
        return;
      case 1:
        members_.push_back(members_[at]);
        return;
      default:
        members_[at].name = "logic-1-" + std::to_string(1 + below(9));
    }
  }

  // Adds or removes a sample of a run, so that a change comes later or earlier.
  void move_change(std::string& samples) {
    if (samples.empty()) return;
    const std::size_t at = below(samples.size());
    if (below(2) == 0 && samples.size() < most_samples) {
      samples.insert(at, 1 + below(4), samples[at]);
    } else {
      samples.erase(at, 1 + below(4));
    }
  }
};

}  // namespace biss::fuzz
