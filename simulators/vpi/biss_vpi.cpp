// The VPI module: system tasks that put encoders and masters of simulators/testbench.h into a
// Verilog simulation. simulators/vpi/biss.v has modules around them.
//
//   $biss_encoder(name, settings, ma, slo)                 slo, a reg, is driven from here on
//   $biss_master(name, settings, ma, slo, request, latches, requests)
//                                                          ma and the two counters, regs, are driven
//   $biss_next(name, channel, position, nE, nW)
//   $biss_value(name, channel, position, nE, nW)
//   $biss_compare(name, cause)
//   failures = $biss_report(path)
#include <vpi_user.h>

#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "simulators/testbench.h"

// An extension of Icarus Verilog.
extern "C" [[gnu::weak]] void vpip_set_return_value(int value);

namespace {

constexpr std::int64_t never = -1;

// ---- Time

// The time unit of the simulation, which callbacks and vpi_get_time() count in.
struct Unit {
  std::int64_t ps_per_tick = 1;
  std::int64_t ticks_per_ps = 1;

  std::int64_t ps(std::int64_t ticks) const { return ticks / ticks_per_ps * ps_per_tick; }
  // Rounded up, so that nothing is called before it is due.
  std::int64_t ticks(std::int64_t ps) const {
    return (ps + ps_per_tick - 1) / ps_per_tick * ticks_per_ps;
  }
};

Unit unit_of_simulation() {
  Unit unit;
  for (int exponent = vpi_get(vpiTimePrecision, nullptr); exponent > -12; --exponent) {
    unit.ps_per_tick *= 10;
  }
  for (int exponent = vpi_get(vpiTimePrecision, nullptr); exponent < -12; ++exponent) {
    unit.ticks_per_ps *= 10;
  }
  return unit;
}

std::int64_t now_ticks() {
  s_vpi_time time{};
  time.type = vpiSimTime;
  vpi_get_time(nullptr, &time);
  return static_cast<std::int64_t>(std::uint64_t{time.high} << 32U | time.low);
}

// ---- Values

s_vpi_value value_of(vpiHandle object, PLI_INT32 format) {
  s_vpi_value value{};
  value.format = format;
  vpi_get_value(object, &value);
  return value;
}

int scalar_of(vpiHandle signal) { return value_of(signal, vpiScalarVal).value.scalar; }
int number_of(vpiHandle argument) { return value_of(argument, vpiIntVal).value.integer; }

std::string text_of(vpiHandle argument) {
  const char* text = value_of(argument, vpiStringVal).value.str;
  return text == nullptr ? "" : text;
}

void put_number(vpiHandle signal, int number) {
  s_vpi_value value{};
  value.format = vpiIntVal;
  value.value.integer = number;
  vpi_put_value(signal, &value, nullptr, vpiNoDelay);
}

struct Vector {
  std::uint64_t bits = 0;
  bool known = true;
};

// Up to 64 bits; further ones that are not 0 make it unknown.
Vector vector_of(vpiHandle argument) {
  Vector result;
  const int size = vpi_get(vpiSize, argument);
  const s_vpi_value value = value_of(argument, vpiVectorVal);
  for (int k = 0; k * 32 < size; ++k) {
    const int rest = size - k * 32;
    const std::uint32_t mask = rest >= 32 ? UINT32_MAX : (std::uint32_t{1} << rest) - 1U;
    const auto a = static_cast<std::uint32_t>(value.value.vector[k].aval) & mask;
    const auto b = static_cast<std::uint32_t>(value.value.vector[k].bval) & mask;
    if (b != 0 || (k > 1 && a != 0)) result.known = false;
    if (k < 2) result.bits |= std::uint64_t{a} << (32 * k);
  }
  return result;
}

// ---- The arguments of a call

std::vector<vpiHandle> arguments_of_call() {
  std::vector<vpiHandle> arguments;
  vpiHandle call = vpi_handle(vpiSysTfCall, nullptr);
  vpiHandle list = vpi_iterate(vpiArgument, call);
  if (list == nullptr) return arguments;
  while (vpiHandle argument = vpi_scan(list)) arguments.push_back(argument);
  return arguments;
}

void stop(const char* task, const char* why) {
  vpi_printf("biss: %s: %s\n", task, why);
  if (vpip_set_return_value != nullptr) vpip_set_return_value(1);
  vpi_control(vpiFinish, 1);
}

// ---- Encoders and masters

// A signal that an instance drives, and the last value.
struct Output {
  vpiHandle signal;
  int (*value)(int id);
  int last;
};

// An instance and its signals. Callbacks keep its address until the simulation ends.
class Stepper {
 public:
  // \param arguments of $biss_encoder or $biss_master; an encoder has only MA and SLO
  Stepper(int id, const std::vector<vpiHandle>& arguments) : id_(id) {
    const vpiHandle ma = arguments[2];
    const vpiHandle slo = arguments[3];
    if (arguments.size() == 4) {
      input_ = ma;
      outputs_ = {{slo, &biss_tb_level, 1}};
    } else {
      input_ = slo;
      request_ = arguments[4];
      outputs_ = {{arguments[5], &biss_tb_latches, 0},
                  {ma, &biss_tb_level, 1},
                  {arguments[6], &biss_tb_requests, 0}};
      watch(request_);
    }
    watch(input_);
    for (const Output& output : outputs_) put_number(output.signal, output.last);
  }
  void step();

 private:
  static PLI_INT32 changed(p_cb_data data);
  static PLI_INT32 woken(p_cb_data data);
  void watch(vpiHandle signal);
  std::int64_t step_at(std::int64_t now_ps);
  void wake_at(std::int64_t ticks, std::int64_t now);

  int id_;
  vpiHandle input_ = nullptr;
  vpiHandle request_ = nullptr;
  std::vector<Output> outputs_;
  Unit unit_ = unit_of_simulation();
  std::int64_t wake_ = never;
  s_vpi_time time_{};
  s_vpi_value value_{};
};

PLI_INT32 Stepper::changed(p_cb_data data) {
  reinterpret_cast<Stepper*>(data->user_data)->step();
  return 0;
}

PLI_INT32 Stepper::woken(p_cb_data data) {
  auto& self = *reinterpret_cast<Stepper*>(data->user_data);
  if (now_ticks() >= self.wake_) self.wake_ = never;
  self.step();
  return 0;
}

void Stepper::watch(vpiHandle signal) {
  time_.type = vpiSuppressTime;
  value_.format = vpiSuppressVal;
  s_cb_data data{};
  data.reason = cbValueChange;
  data.cb_rtn = &Stepper::changed;
  data.obj = signal;
  data.time = &time_;
  data.value = &value_;
  data.user_data = reinterpret_cast<PLI_BYTE8*>(this);
  vpi_register_cb(&data);
}

// Passes inputs on and drives outputs. A line that nothing drives is high; an unknown request is
// not a request. \return the deadline
std::int64_t Stepper::step_at(std::int64_t now_ps) {
  const int level = scalar_of(input_) == vpi0 ? 0 : 1;
  const std::int64_t deadline =
      request_ == nullptr
          ? biss_tb_step_encoder(id_, now_ps, level)
          : biss_tb_step_master(id_, now_ps, level, scalar_of(request_) == vpi1 ? 1 : 0);
  for (Output& output : outputs_) {
    const int value = output.value(id_);
    if (value != output.last) put_number(output.signal, output.last = value);
  }
  return deadline;
}

void Stepper::step() {
  const std::int64_t now = now_ticks();
  const std::int64_t deadline = step_at(unit_.ps(now));
  if (deadline == never) return;
  const std::int64_t ticks = unit_.ticks(deadline);
  if (wake_ == never || ticks < wake_) wake_at(ticks, now);
}

void Stepper::wake_at(std::int64_t ticks, std::int64_t now) {
  const auto delay = static_cast<std::uint64_t>(ticks > now ? ticks - now : 1);
  wake_ = now + static_cast<std::int64_t>(delay);
  s_vpi_time time{};
  time.type = vpiSimTime;
  time.high = static_cast<PLI_UINT32>(delay >> 32U);
  time.low = static_cast<PLI_UINT32>(delay & UINT32_MAX);
  s_cb_data data{};
  data.reason = cbAfterDelay;
  data.cb_rtn = &Stepper::woken;
  data.time = &time;
  data.user_data = reinterpret_cast<PLI_BYTE8*>(this);
  vpi_register_cb(&data);
}

// ---- The system tasks

using Arguments = std::vector<vpiHandle>;

struct Task {
  const char* name;
  std::size_t argument_count;
  void (*call)(const Arguments& arguments);
};

void open(const Arguments& arguments, int (*open_instance)(const char*, const char*),
          const char* task, const char* failure) {
  static std::vector<std::unique_ptr<Stepper>> steppers;
  const int id = open_instance(text_of(arguments[0]).c_str(), text_of(arguments[1]).c_str());
  if (id == 0) return stop(task, failure);
  steppers.push_back(std::make_unique<Stepper>(id, arguments));
  steppers.back()->step();
}

// The arguments of $biss_next and $biss_value.
struct Given {
  explicit Given(const Arguments& arguments)
      : name(text_of(arguments[0])), channel(number_of(arguments[1])) {
    const Vector vectors[] = {vector_of(arguments[2]), vector_of(arguments[3]),
                              vector_of(arguments[4])};
    known = vectors[0].known && vectors[1].known && vectors[2].known;
    position = static_cast<long long>(vectors[0].bits);
    nE = static_cast<int>(vectors[1].bits & 1U);
    nW = static_cast<int>(vectors[2].bits & 1U);
  }

  std::string name;
  int channel;
  long long position;
  bool known;
  int nE;
  int nW;
};

constexpr Task tasks[] = {
    {"$biss_encoder", 4,
     [](const Arguments& arguments) {
       open(arguments, &biss_tb_encoder, "$biss_encoder", "no encoder");
     }},
    {"$biss_master", 7,
     [](const Arguments& arguments) {
       open(arguments, &biss_tb_master, "$biss_master", "no master");
     }},
    {"$biss_next", 5,
     [](const Arguments& arguments) {
       const Given given(arguments);
       biss_tb_next(given.name.c_str(), given.channel, given.position, given.known ? given.nE : -1,
                    given.nW);
     }},
    {"$biss_value", 5,
     [](const Arguments& arguments) {
       const Given given(arguments);
       biss_tb_value(given.name.c_str(), given.channel, given.position, given.known ? 1 : 0,
                     given.nE, given.nW);
     }},
    {"$biss_compare", 2,
     [](const Arguments& arguments) {
       biss_tb_compare(text_of(arguments[0]).c_str(), text_of(arguments[1]).c_str());
     }},
    {"$biss_report", 1,
     [](const Arguments& arguments) {
       put_number(vpi_handle(vpiSysTfCall, nullptr), biss_tb_report(text_of(arguments[0]).c_str()));
     }},
};

PLI_INT32 call_task(PLI_BYTE8* user) {
  const auto& task = *reinterpret_cast<const Task*>(user);
  const Arguments arguments = arguments_of_call();
  if (arguments.size() == task.argument_count) {
    task.call(arguments);
  } else {
    stop(task.name, "wrong number of arguments");
  }
  return 0;
}

void register_all() {
  for (const Task& task : tasks) {
    const bool is_function = &task == std::end(tasks) - 1;  // $biss_report
    s_vpi_systf_data data{};
    data.type = is_function ? vpiSysFunc : vpiSysTask;
    data.sysfunctype = is_function ? vpiIntFunc : 0;
    data.tfname = task.name;
    data.calltf = &call_task;
    data.sizetf = [](PLI_BYTE8*) { return PLI_INT32{32}; };
    data.user_data = reinterpret_cast<PLI_BYTE8*>(const_cast<Task*>(&task));
    vpi_register_systf(&data);
  }
}

}  // namespace

extern "C" {
// The simulator finds it by this name.
[[gnu::visibility("default")]] void (*vlog_startup_routines[])() = {&register_all, nullptr};
}
