// Mutations of a sigrok session that mostly leave a valid session: the members are changed and
// packed again, and sometimes the archive itself is changed.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/sr.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/token_mutator.hpp"
#include "fuzz/zip_members.hpp"

namespace biss::fuzz {

class SrMutator {
 public:
  explicit SrMutator(std::uint64_t seed) : random_{seed} {}

  /// Changes `archive` in one or two places, and replaces an invalid session by a new seed.
  std::string mutate(std::string archive) {
    const std::uint64_t kind = below(16);
    if (kind == 1) return changed_header(std::move(archive));
    if (kind == 2) return changed_bytes(std::move(archive), 16);
    members_ = unpack_zip(archive, most_samples);
    if (kind == 0 || members_.size() < 3) new_members();
    change_member(kind);
    archive = ZipPacker(random_).pack(members_);
    return below(32) == 0 ? changed_header(std::move(archive)) : archive;
  }

 private:
  // Larger members are not used for the next generation.
  static constexpr std::size_t most_samples = 1U << 16U;

  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(random_() % limit); }

  void new_members() {
    const std::uint64_t seed = random_();
    members_ = {{"version", "2"},
                {"metadata", capture::sr_metadata_text(sampled_layout(seed))},
                {"logic-1-1", raw_seed(seed)}};
  }

  // A member whose name begins with `begins`; any member if there is none.
  std::string& text_of(std::string_view begins) {
    const std::size_t first = below(members_.size());
    for (std::size_t i = 0; i < members_.size(); ++i) {
      ZipText& member = members_[(first + i) % members_.size()];
      if (member.name.starts_with(begins)) return member.text;
    }
    return members_[first].text;
  }

  void change_member(std::uint64_t kind) {
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

  std::string changed_bytes(std::string bytes, std::size_t growth) {
    const std::size_t size = bytes.size();
    bytes.resize(size + growth);
    bytes.resize(
        LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
    return bytes;
  }

  // Replaces a number in one of the headers or after it.
  std::string changed_header(std::string archive) {
    std::size_t at = archive.find("PK", below(archive.size()));
    if (at == std::string::npos) at = archive.rfind("PK");
    if (at == std::string::npos) return archive;
    at = std::min(at + below(48), archive.size());
    const std::size_t bytes = std::min<std::size_t>(1 + below(4), archive.size() - at);
    const std::uint64_t value = random_() >> below(64);
    for (std::size_t i = 0; i < bytes; ++i) archive[at + i] = static_cast<char>(value >> (8 * i));
    return archive;
  }

  SplitMix random_;
  std::vector<ZipText> members_;
};

}  // namespace biss::fuzz
