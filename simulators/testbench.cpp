#include "simulators/testbench.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "simulators/encoder.hpp"
#include "simulators/master.hpp"
#include "simulators/report.hpp"

namespace biss::simulators {

namespace {

// All instances of a simulation, numbered from 1.
struct Bench {
  Bench() = default;
  Bench& operator=(Bench&&) = default;
  // At the end of the program.
  ~Bench() {
    if (instances.empty()) return;
    std::fprintf(stderr, "biss: the simulation ended without a report: nothing is proven\n");
  }

  Instances instances;
  std::uint64_t errors = 0;
};

Bench& bench() {
  static Bench the_bench;
  return the_bench;
}

void complain(const std::string& text) {
  ++bench().errors;
  std::fflush(stdout);
  std::fprintf(stderr, "biss: %s\n", text.c_str());
}

// A C interface: no exception may leave it.
template <class Result, class Call>
Result guarded(Result failed, Call call) {
  try {
    return call();
  } catch (const std::exception& error) {
    complain(error.what());
    return failed;
  }
}

Instance* find(std::string_view name) {
  for (const auto& instance : bench().instances) {
    if (instance->name() == name) return instance.get();
  }
  complain(fmt::format("no encoder and no master has the name '{}'", name));
  return nullptr;
}

template <class Kind>
Kind* of_number(int id, Role role) {
  const auto& instances = bench().instances;
  if (id < 1 || static_cast<std::size_t>(id) > instances.size()) return nullptr;
  Instance* instance = instances[static_cast<std::size_t>(id) - 1].get();
  return instance->role() == role ? static_cast<Kind*>(instance) : nullptr;
}

Instance* of_number(int id) {
  Instance* encoder = of_number<Encoder>(id, Role::encoder);
  return encoder != nullptr ? encoder : of_number<Master>(id, Role::master);
}

template <class Kind>
int open(Role role, const char* given_name, const char* given_settings) {
  const std::string name = given_name == nullptr ? "" : given_name;
  auto settings = read_settings(role, given_settings == nullptr ? "" : given_settings);
  if (!settings) {
    complain(fmt::format("{}: {}", name, settings.error()));
    return 0;
  }
  auto& instances = bench().instances;
  for (const auto& instance : instances) {
    if (instance->name() != name) continue;
    complain(fmt::format("{}: this name is taken", name));
    return 0;
  }
  instances.push_back(std::make_unique<Kind>(name, std::move(*settings)));
  return static_cast<int>(instances.size());
}

// The channel, or nothing and an error message.
std::optional<std::size_t> channel_of(const Instance& instance, int channel) {
  if (channel >= 0 && channel < instance.settings().format.channel_count) {
    return static_cast<std::size_t>(channel);
  }
  complain(fmt::format("{}: no channel {}", instance.name(), channel));
  return std::nullopt;
}

bool write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) complain(fmt::format("{}: cannot be written", path));
  return static_cast<bool>(file);
}

int report(const std::string& path) {
  Bench& all = bench();
  for (const auto& instance : all.instances) instance->finish();
  if (all.instances.empty()) complain("no encoder and no master");
  const std::string text = report_text(all.instances, all.errors);
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
  if (!path.empty()) {
    write_file(path + ".txt", text);
    write_file(path + ".json", report_json(all.instances, all.errors));
  }
  std::uint64_t failures = all.errors;
  for (const auto& instance : all.instances) failures += failures_of(*instance);
  all = {};
  return failures > INT32_MAX ? INT32_MAX : static_cast<int>(failures);
}

long long as_deadline(std::int64_t deadline) { return deadline == BISS_NEVER ? -1 : deadline; }

}  // namespace

}  // namespace biss::simulators

extern "C" {

using biss::simulators::Role;

int biss_tb_encoder(const char* name, const char* settings) {
  return biss::simulators::guarded(0, [&] {
    return biss::simulators::open<biss::simulators::Encoder>(Role::encoder, name, settings);
  });
}

int biss_tb_master(const char* name, const char* settings) {
  return biss::simulators::guarded(0, [&] {
    return biss::simulators::open<biss::simulators::Master>(Role::master, name, settings);
  });
}

long long biss_tb_step_encoder(int id, long long now_ps, int ma) {
  return biss::simulators::guarded(-1LL, [&] {
    auto* encoder = biss::simulators::of_number<biss::simulators::Encoder>(id, Role::encoder);
    if (encoder == nullptr) return -1LL;
    return biss::simulators::as_deadline(encoder->step(now_ps, ma != 0));
  });
}

long long biss_tb_step_master(int id, long long now_ps, int slo, int request) {
  return biss::simulators::guarded(-1LL, [&] {
    auto* master = biss::simulators::of_number<biss::simulators::Master>(id, Role::master);
    if (master == nullptr) return -1LL;
    return biss::simulators::as_deadline(master->step(now_ps, slo != 0, request != 0));
  });
}

int biss_tb_level(int id) {
  const auto* instance = biss::simulators::of_number(id);
  return instance == nullptr || instance->level() ? 1 : 0;
}

int biss_tb_latches(int id) {
  const auto* master = biss::simulators::of_number<biss::simulators::Master>(id, Role::master);
  return master == nullptr ? 0 : static_cast<int>(master->latches());
}

int biss_tb_requests(int id) {
  const auto* instance = biss::simulators::of_number(id);
  return instance == nullptr ? 0 : static_cast<int>(instance->requests());
}

void biss_tb_next(const char* name, int channel, long long position, int nE, int nW) {
  biss::simulators::guarded(0, [&] {
    auto* instance = biss::simulators::find(name == nullptr ? "" : name);
    if (instance == nullptr) return 0;
    const auto k = biss::simulators::channel_of(*instance, channel);
    if (!k) return 0;
    if (nE < 0 || nW < 0) {
      biss::simulators::complain(instance->name() + ": the next frame has unknown bits");
      return 0;
    }
    if (instance->role() != Role::encoder) {
      biss::simulators::complain(instance->name() + ": a master sends no position");
      return 0;
    }
    static_cast<biss::simulators::Encoder*>(instance)->set_next(
        *k, {static_cast<std::uint64_t>(position), 0, nE != 0, nW != 0});
    return 0;
  });
}

void biss_tb_value(const char* name, int channel, long long position, int known, int nE, int nW) {
  biss::simulators::guarded(0, [&] {
    auto* instance = biss::simulators::find(name == nullptr ? "" : name);
    if (instance == nullptr) return 0;
    if (const auto k = biss::simulators::channel_of(*instance, channel)) {
      instance->set_value(
          *k, {{static_cast<std::uint64_t>(position), 0, nE != 0, nW != 0}, true, known != 0});
    }
    return 0;
  });
}

int biss_tb_compare(const char* name, const char* cause) {
  return biss::simulators::guarded(0, [&] {
    auto* instance = biss::simulators::find(name == nullptr ? "" : name);
    if (instance == nullptr) return 0;
    return instance->compare(cause == nullptr ? "" : cause) ? 1 : 0;
  });
}

int biss_tb_report(const char* path) {
  return biss::simulators::guarded(
      1, [&] { return biss::simulators::report(path == nullptr ? "" : path); });
}

}  // extern "C"
