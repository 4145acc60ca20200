#include "tests/archive/archive_folder.hpp"

#include <sys/wait.h>

#include <random>
#include <thread>

namespace biss::verbs {

namespace {

namespace fs = std::filesystem;

// Encoders, clocks, cables and faults of the captures that all others are copies of.
const std::vector<std::vector<std::string>>& lines_simulated() {
  static const std::vector<std::vector<std::string>> lines{
      {"-f", "resolute-26", "--clock", "5MHz", "--cable", "30m"},
      {"-f", "resolute-32", "--clock", "2MHz", "--cable", "5m", "--fault", "flip:0.1"},
      {"-f", "fs-36-28", "--clock", "4MHz", "--fault", "nE:0.2", "--fault", "late_start:0.05"},
      {"-f", "fortis-36", "--clock", "2500kHz", "--cable", "10m", "--jitter", "5ns", "--fault",
       "no_answer:0.05"},
      {"-f", "pos22,nE,nW,crc6", "--clock", "1MHz", "--fault", "nW:0.1", "--fault", "cut:0.05"},
      {"-f", "mt12,st20,nE,nW,crc6", "--clock", "3MHz", "--cable", "80m", "--fault",
       "glitch_ma:0.05"}};
  return lines;
}

// The content of each simulated capture, and its extension.
struct Original {
  std::string extension;
  std::string content;
};

std::vector<Original> simulate_all(const Folder& folder) {
  std::vector<Original> originals;
  int seed = 0;
  for (const auto& line : lines_simulated()) {
    for (const char* extension : {".vcd", ".csv", ".sr", ".dsl", ".saleae.csv"}) {
      const std::string path = folder.path(fmt::format("original{}{}", ++seed, extension));
      run_ok(Words("simulate --cycles 40 --motion random --seed {} -o {}", seed, path) + line);
      originals.push_back({extension, content_of(path)});
    }
  }
  return originals;
}

using Random = std::mt19937_64;

// One file in five is not as it was simulated.
void damage(std::string& content, std::size_t number, Random& random) {
  switch (number % 20) {
    case 3:
    case 13:
      content.resize(random() % content.size());
      return;
    case 7:
      for (int i = 0; i < 20; ++i) content[random() % content.size()] = static_cast<char>(random());
      return;
    case 17:
      for (char& byte : content) byte = static_cast<char>(random());
      return;
    default:
      return;
  }
}

std::size_t size_of(const std::string& path) {
  std::error_code missing;
  const auto size = fs::file_size(path, missing);
  return missing ? 0 : static_cast<std::size_t>(size);
}

}  // namespace

ArchiveFolder::ArchiveFolder(std::size_t files) {
  const Folder made;
  const std::vector<Original> originals = simulate_all(made);
  Random random(13);
  for (std::size_t number = 0; number < files; ++number) {
    const Original& original = originals[number % originals.size()];
    const fs::path folder =
        fs::path(path()) / fmt::format("machine-{}", number % 7) / fmt::format("x{}", number % 3);
    fs::create_directories(folder);
    std::string name =
        fmt::format("2024-{:02}-{:02}_{:04}", 1 + number % 12, 1 + number % 28, number);
    std::string content = original.content;
    damage(content, number, random);
    if (number % 40 == 29) {
      name += number % 80 == 29 ? ".txt" : ".csv";
      content = "axis,comment\nx,replaced\n";
    } else if (number % 40 == 39) {
      name += ".sr";
      content.clear();
    } else {
      name += original.extension;
    }
    std::ofstream(folder / name, std::ios::binary) << content;
  }
}

namespace {

// Kills the command as soon as the journal has this many bytes more than before, if it lives that
// long. True where it was killed.
bool killed_at(const std::vector<std::string>& arguments, const std::string& journal,
               std::size_t bytes) {
  const std::size_t before = size_of(journal);
  const pid_t child = start(Words{BISS_COMMAND} + arguments);
  EXPECT_GT(child, 0);
  if (child <= 0) return false;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (size_of(journal) >= before + bytes) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      break;
    }
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  return WIFSIGNALED(status);
}

}  // namespace

int kill_and_resume(const ArchiveFolder& archive, int kills, unsigned seed) {
  const std::string whole = summary_of(archive, "2");
  const std::string output = archive.beside("killed.json");
  const std::string journal = output + ".journal";
  const std::vector<std::string> arguments{"archive", archive.path(), "--threads",
                                           "2",       "-o",           output};
  const std::size_t all = size_of(archive.beside("whole2.json.journal"));
  Random random(seed);
  int killed = 0;
  for (int i = 0; i < kills; ++i) {
    const std::size_t share = all / static_cast<std::size_t>(kills);
    if (killed_at(arguments, journal, random() % (2 * share))) ++killed;
    if (fs::exists(output)) {
      EXPECT_EQ(content_of(output), whole);
    }
  }
  run_ok(arguments);
  EXPECT_EQ(content_of(output), whole) << "seed " << seed;
  return killed;
}

std::string summary_of(const ArchiveFolder& archive, const std::string& threads) {
  const std::string output = archive.beside("whole" + threads + ".json");
  run_ok("archive {} --threads {} -o {} --worst 0", archive.path(), threads, output);
  return content_of(output);
}

std::string merged_summary_of(const ArchiveFolder& archive, unsigned shards) {
  std::vector<std::string> merge{"archive", "merge"};
  for (unsigned shard = shards; shard > 0; --shard) {
    const std::string part = archive.beside(fmt::format("part{}.json", shard));
    run_ok({"archive", archive.path(), "--shard", fmt::format("{}/{}", shard, shards), "-o", part});
    merge.push_back(part);
  }
  const std::string output = archive.beside("merged.json");
  merge.insert(merge.end(), {"-o", output});
  run_ok(merge);
  return content_of(output);
}

}  // namespace biss::verbs
