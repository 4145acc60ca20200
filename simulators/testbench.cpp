#include "simulators/testbench.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <fstream>
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

std::string text_of(const char* given) { return given == nullptr ? "" : given; }

Instance* find(std::string_view name) {
  for (const auto& instance : bench().instances) {
    if (instance->name() == name) return instance.get();
  }
  return nullptr;
}

// Calls `call` with the instance of this name.
template <class Call>
int with(const char* name, Call call) {
  return guarded(0, [&] {
    Instance* instance = find(text_of(name));
    if (instance != nullptr) return call(*instance);
    complain(fmt::format("no encoder and no master has the name '{}'", text_of(name)));
    return 0;
  });
}

// Null if there is no such instance, or if it is not of this kind.
template <class Kind = Instance>
Kind* of_number(int id) {
  const auto& instances = bench().instances;
  if (id < 1 || static_cast<std::size_t>(id) > instances.size()) return nullptr;
  return dynamic_cast<Kind*>(instances[static_cast<std::size_t>(id) - 1].get());
}

template <class Kind>
int open(Role role, const char* given_name, const char* given_settings) {
  return guarded(0, [&] {
    const std::string name = text_of(given_name);
    auto settings = read_settings(role, text_of(given_settings));
    if (!settings) {
      complain(fmt::format("{}: {}", name, settings.error()));
      return 0;
    }
    if (find(name) != nullptr) {
      complain(fmt::format("{}: this name is taken", name));
      return 0;
    }
    auto& instances = bench().instances;
    instances.push_back(std::make_unique<Kind>(name, std::move(*settings)));
    return static_cast<int>(instances.size());
  });
}

// Steps the instance with these levels. \return -1 without a deadline
template <class Kind, class... Levels>
long long step(int id, long long now_ps, Levels... levels) {
  return guarded(-1LL, [&] {
    auto* instance = of_number<Kind>(id);
    if (instance == nullptr) return -1LL;
    const std::int64_t deadline = instance->step(now_ps, (levels != 0)...);
    return deadline == BISS_NEVER ? -1LL : static_cast<long long>(deadline);
  });
}

// False and an error message: there is no such channel.
bool has_channel(const Instance& instance, int channel) {
  if (channel >= 0 && channel < instance.settings().format.channel_count) return true;
  complain(fmt::format("{}: no channel {}", instance.name(), channel));
  return false;
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) complain(fmt::format("{}: cannot be written", path));
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

}  // namespace

}  // namespace biss::simulators

using namespace biss::simulators;

extern "C" {

int biss_tb_encoder(const char* name, const char* settings) {
  return open<Encoder>(Role::encoder, name, settings);
}

int biss_tb_master(const char* name, const char* settings) {
  return open<Master>(Role::master, name, settings);
}

long long biss_tb_step_encoder(int id, long long now_ps, int ma) {
  return step<Encoder>(id, now_ps, ma);
}

long long biss_tb_step_master(int id, long long now_ps, int slo, int request) {
  return step<Master>(id, now_ps, slo, request);
}

int biss_tb_level(int id) {
  const auto* instance = of_number(id);
  return instance == nullptr || instance->level() ? 1 : 0;
}

int biss_tb_latches(int id) {
  const auto* master = of_number<Master>(id);
  return master == nullptr ? 0 : static_cast<int>(master->latches());
}

int biss_tb_requests(int id) {
  const auto* instance = of_number(id);
  return instance == nullptr ? 0 : static_cast<int>(instance->requests());
}

void biss_tb_next(const char* name, int channel, long long position, int nE, int nW) {
  with(name, [&](Instance& instance) {
    if (!has_channel(instance, channel)) return 0;
    if (nE < 0 || nW < 0) {
      complain(instance.name() + ": the next frame has unknown bits");
    } else if (instance.role() != Role::encoder) {
      complain(instance.name() + ": a master sends no position");
    } else {
      static_cast<Encoder&>(instance).set_next(
          static_cast<std::size_t>(channel),
          {static_cast<std::uint64_t>(position), 0, nE != 0, nW != 0});
    }
    return 0;
  });
}

void biss_tb_value(const char* name, int channel, long long position, int known, int nE, int nW) {
  with(name, [&](Instance& instance) {
    if (has_channel(instance, channel)) {
      instance.set_value(
          static_cast<std::size_t>(channel),
          {{static_cast<std::uint64_t>(position), 0, nE != 0, nW != 0}, true, known != 0});
    }
    return 0;
  });
}

int biss_tb_compare(const char* name, const char* cause) {
  return with(name, [&](Instance& instance) { return instance.compare(text_of(cause)) ? 1 : 0; });
}

int biss_tb_report(const char* path) {
  return guarded(1, [&] { return report(text_of(path)); });
}

}  // extern "C"
