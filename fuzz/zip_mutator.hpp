// Mutations of ZIP archives that mostly leave a valid one: the members are changed and packed again
// without the cost of compression, and sometimes the archive itself is changed.
#pragma once

#include "capture/sr.hpp"
#include "capture/zip.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/mutate.hpp"

namespace biss::fuzz {

struct ZipText {
  std::string name;
  std::string text;
};

inline std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The undamaged members of at most `most_bytes`; none if the archive cannot be read.
inline std::vector<ZipText> unpack_zip(std::string_view archive, std::size_t most_bytes) {
  std::vector<ZipText> members;
  const auto opened = capture::ZipArchive::open(capture::memory_bytes(archive));
  if (!opened) return members;
  for (std::string& name : (*opened)->names("")) {
    auto text = (*opened)->read_text(*(*opened)->find(name), most_bytes);
    if (text) members.push_back({std::move(name), std::move(*text)});
  }
  return members;
}

// Fields of PKWARE's APPNOTE, 4.3.7 and 4.3.12; a block of stored bytes is RFC 1951, 3.2.4.
/// An archive of these members: some stored, most deflated into a block without compression, a few
/// compressed, at random.
class ZipPacker {
 public:
  explicit ZipPacker(SplitMix& random) : random_(random) {}

  std::string pack(const std::vector<ZipText>& members) {
    const bool compressed = random_() % 16 == 0;
    for (const ZipText& member : members) add(member, compressed);
    const std::size_t directory = out_.size();
    out_ += directory_;
    out_ += "PK\x05\x06";
    capture::put_number(out_, 0, 4);
    capture::put_number(out_, members.size(), 2);
    capture::put_number(out_, members.size(), 2);
    capture::put_number(out_, directory_.size(), 4);
    capture::put_number(out_, directory, 4);
    capture::put_number(out_, 0, 2);
    return std::move(out_);
  }

 private:
  void add(const ZipText& member, bool compressed) {
    const bool too_long = member.text.size() > 0xFFFF;
    const bool deflated = compressed || too_long || random_() % 4 != 0;
    std::string data;
    if (compressed || too_long) {
      static capture::Deflater deflater;
      deflater.deflate(bytes_of(member.text), data);
    } else {
      if (deflated) {
        data += '\1';
        capture::put_number(data, member.text.size(), 2);
        capture::put_number(data, ~member.text.size(), 2);
      }
      data += member.text;
    }
    // The fields that a local header and the directory share: version, flags, method, date and
    // sizes.
    std::string shared;
    capture::put_number(shared, 20, 2);
    capture::put_number(shared, 0x0800, 2);
    capture::put_number(shared, deflated ? 8 : 0, 2);
    capture::put_number(shared, 0x0021'0000, 4);
    capture::put_number(shared, capture::zip_checksum(bytes_of(member.text)), 4);
    capture::put_number(shared, data.size(), 4);
    capture::put_number(shared, member.text.size(), 4);
    capture::put_number(shared, member.name.size(), 2);
    capture::put_number(shared, 0, 2);
    directory_ += "PK\x01\x02";
    capture::put_number(directory_, 0x0314, 2);
    directory_ += shared;
    capture::put_number(directory_, 0, 10);
    capture::put_number(directory_, out_.size(), 4);
    directory_ += member.name;
    out_ += "PK\x03\x04" + shared + member.name + data;
  }

  SplitMix& random_;
  std::string out_;
  std::string directory_;
};

/// The members of a kind of capture.
struct ZipKind {
  std::string_view header;   ///< the name of the member with the settings
  std::string_view samples;  ///< the beginning of the names of members with samples
  std::string_view words;    ///< of the header
  std::string (*seed)(std::uint64_t seed);
};

inline constexpr ZipKind sr_kind{
    "metadata", "logic-1",
    "[device 1]|[device 2]|[global]|capturefile=logic-1|capturefile=version|unitsize=2|unitsize=8|"
    "unitsize=9|samplerate=0|samplerate=4 GHz|samplerate=1 Hz|samplerate=33.3 MHz|probe1=SLO|"
    "probe8=MA|probe64=x|probe0=x|total probes=99|=|\\s\\n\\|analog3=A",
    sampled_seed<capture::SrWriter>};

inline constexpr ZipKind dsl_kind{
    "header", "L-",
    "[version]|version = 2|version = 1|[header]|[header 2]|capturefile = L-0/0|device mode = 1|"
    "samplerate = 4 GHz|samplerate = 1 Hz|samplerate = 33.3 MHz|"
    "total samples = 18446744073709551615|total samples = 1000|total blocks = 2|total blocks = 0|"
    "probe0 = SLO|probe1 = MA|probe63 = x|\\s\\",
    sampled_seed<capture::DslWriter>};

class ZipMutator {
 public:
  ZipMutator(const ZipKind& kind, SplitMix& random) : kind_(kind), random_(random) {}

  /// Changes `archive` in one or two places, and replaces an invalid capture by a new seed.
  std::string mutate(std::string archive) {
    if (below(16) == 0) return changed_header(std::move(archive));
    members_ = unpack_zip(archive, most_samples);
    if (members_.size() < 3) members_ = unpack_zip(kind_.seed(random_()), most_samples);
    change_member();
    archive = ZipPacker(random_).pack(members_);
    return below(32) == 0 ? changed_header(std::move(archive)) : archive;
  }

 private:
  // Larger members are not used for the next generation.
  static constexpr std::size_t most_samples = 1U << 16U;

  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(random_() % limit); }

  // A member whose name begins with `begins`; any member if there is none.
  std::string& text_of(std::string_view begins) {
    const std::size_t first = below(members_.size());
    for (std::size_t i = 0; i < members_.size(); ++i) {
      ZipText& member = members_[(first + i) % members_.size()];
      if (member.name.starts_with(begins)) return member.text;
    }
    return members_[first].text;
  }

  void change_member() {
    const std::size_t choice = below(16);
    if (choice < 5) {
      std::string& text = text_of(kind_.header);
      text = TokenMutator(std::move(text), "=\n", kind_.words, random_).mutate();
    } else if (choice < 7) {
      is_sr() ? cut_chunks() : change_list();
    } else if (choice == 7) {
      change_list();
    } else {
      std::string& samples = text_of(kind_.samples);
      if (choice < 10) {
        samples = changed_bytes(std::move(samples), is_sr() ? 64 : 8);
      } else {
        move_change(samples);
      }
    }
  }

  bool is_sr() const { return kind_.header == sr_kind.header; }

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
        members_[at].name = is_sr() ? "logic-1-" + std::to_string(1 + below(9))
                                    : "L-" + std::to_string(below(3)) + "/0";
    }
  }

  // Adds or removes a sample of a run, so that a change comes later or earlier. The planes of DSLogic
  // have a fixed size, and eight samples a byte.
  void move_change(std::string& samples) {
    if (samples.empty()) return;
    const std::size_t at = below(samples.size());
    if (!is_sr()) {
      samples[at] ^= static_cast<char>(1U << below(8));
    } else if (below(2) == 0 && samples.size() < most_samples) {
      samples.insert(at, 1 + below(4), samples[at]);
    } else {
      samples.erase(at, 1 + below(4));
    }
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

  const ZipKind& kind_;
  SplitMix& random_;
  std::vector<ZipText> members_;
};

}  // namespace biss::fuzz
