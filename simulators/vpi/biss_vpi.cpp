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

// 1 unless the signal is 0: a line that nothing drives idles high.
int level_of(vpiHandle signal) {
  s_vpi_value value{};
  value.format = vpiScalarVal;
  vpi_get_value(signal, &value);
  return value.value.scalar == vpi0 ? 0 : 1;
}

void put_level(vpiHandle signal, int level) {
  s_vpi_value value{};
  value.format = vpiScalarVal;
  value.value.scalar = level != 0 ? vpi1 : vpi0;
  vpi_put_value(signal, &value, nullptr, vpiNoDelay);
}

void put_number(vpiHandle signal, int number) {
  s_vpi_value value{};
  value.format = vpiIntVal;
  value.value.integer = number;
  vpi_put_value(signal, &value, nullptr, vpiNoDelay);
}

std::string text_of(vpiHandle argument) {
  s_vpi_value value{};
  value.format = vpiStringVal;
  vpi_get_value(argument, &value);
  return value.value.str == nullptr ? "" : value.value.str;
}

int number_of(vpiHandle argument) {
  s_vpi_value value{};
  value.format = vpiIntVal;
  vpi_get_value(argument, &value);
  return value.value.integer;
}

struct Vector {
  std::uint64_t bits = 0;
  bool known = true;
};

// Up to 64 bits; further ones that are not 0 make it unknown.
Vector vector_of(vpiHandle argument) {
  Vector result;
  const int size = vpi_get(vpiSize, argument);
  s_vpi_value value{};
  value.format = vpiVectorVal;
  vpi_get_value(argument, &value);
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

// False if the number of arguments is wrong; the simulation then stops.
bool take_arguments(const char* task, std::size_t count, std::vector<vpiHandle>& arguments) {
  arguments = arguments_of_call();
  if (arguments.size() == count) return true;
  stop(task, "wrong number of arguments");
  return false;
}

// ---- Encoders and masters

// An instance and its signals. Callbacks keep its address until the simulation ends.
class Stepper {
 public:
  virtual ~Stepper() = default;
  void watch(vpiHandle signal);
  void step();

 protected:
  Stepper(int id, Unit unit) : id_(id), unit_(unit) {}
  int id() const { return id_; }
  // Passes inputs on and drives outputs. \return the deadline
  virtual std::int64_t step_at(std::int64_t now_ps) = 0;

 private:
  static PLI_INT32 changed(p_cb_data data);
  static PLI_INT32 woken(p_cb_data data);
  void wake_at(std::int64_t ticks, std::int64_t now);

  int id_;
  Unit unit_;
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
  s_cb_data data{};
  time_.type = vpiSuppressTime;
  value_.format = vpiSuppressVal;
  data.reason = cbValueChange;
  data.cb_rtn = &Stepper::changed;
  data.obj = signal;
  data.time = &time_;
  data.value = &value_;
  data.user_data = reinterpret_cast<PLI_BYTE8*>(this);
  vpi_register_cb(&data);
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

class EncoderStepper final : public Stepper {
 public:
  EncoderStepper(int id, Unit unit, vpiHandle ma, vpiHandle slo)
      : Stepper(id, unit), ma_(ma), slo_(slo) {
    watch(ma);
    put_level(slo, 1);
  }

 private:
  std::int64_t step_at(std::int64_t now_ps) override {
    const std::int64_t deadline = biss_tb_step_encoder(id(), now_ps, level_of(ma_));
    const int level = biss_tb_level(id());
    if (level != level_) put_level(slo_, level_ = level);
    return deadline;
  }

  vpiHandle ma_;
  vpiHandle slo_;
  int level_ = 1;
};

class MasterStepper final : public Stepper {
 public:
  MasterStepper(int id, Unit unit, const std::vector<vpiHandle>& arguments)
      : Stepper(id, unit),
        ma_(arguments[2]),
        slo_(arguments[3]),
        request_(arguments[4]),
        latches_(arguments[5]),
        requests_(arguments[6]) {
    watch(slo_);
    watch(request_);
    put_level(ma_, 1);
    put_number(latches_, 0);
    put_number(requests_, 0);
  }

 private:
  // No request while the signal is unknown.
  bool requested() const {
    s_vpi_value value{};
    value.format = vpiScalarVal;
    vpi_get_value(request_, &value);
    return value.value.scalar == vpi1;
  }

  std::int64_t step_at(std::int64_t now_ps) override {
    const std::int64_t deadline =
        biss_tb_step_master(id(), now_ps, level_of(slo_), requested() ? 1 : 0);
    const int level = biss_tb_level(id());
    const int latches = biss_tb_latches(id());
    const int requests = biss_tb_requests(id());
    if (latches != latched_) put_number(latches_, latched_ = latches);
    if (level != level_) put_level(ma_, level_ = level);
    if (requests != ended_) put_number(requests_, ended_ = requests);
    return deadline;
  }

  vpiHandle ma_;
  vpiHandle slo_;
  vpiHandle request_;
  vpiHandle latches_;
  vpiHandle requests_;
  int level_ = 1;
  int latched_ = 0;
  int ended_ = 0;
};

std::vector<std::unique_ptr<Stepper>>& steppers() {
  static std::vector<std::unique_ptr<Stepper>> all;
  return all;
}

void keep(std::unique_ptr<Stepper> stepper) {
  stepper->step();
  steppers().push_back(std::move(stepper));
}

// ---- The system tasks

PLI_INT32 encoder_task(PLI_BYTE8* /*user*/) {
  std::vector<vpiHandle> arguments;
  if (!take_arguments("$biss_encoder", 4, arguments)) return 0;
  const int id = biss_tb_encoder(text_of(arguments[0]).c_str(), text_of(arguments[1]).c_str());
  if (id == 0) {
    stop("$biss_encoder", "no encoder");
    return 0;
  }
  keep(std::make_unique<EncoderStepper>(id, unit_of_simulation(), arguments[2], arguments[3]));
  return 0;
}

PLI_INT32 master_task(PLI_BYTE8* /*user*/) {
  std::vector<vpiHandle> arguments;
  if (!take_arguments("$biss_master", 7, arguments)) return 0;
  const int id = biss_tb_master(text_of(arguments[0]).c_str(), text_of(arguments[1]).c_str());
  if (id == 0) {
    stop("$biss_master", "no master");
    return 0;
  }
  keep(std::make_unique<MasterStepper>(id, unit_of_simulation(), arguments));
  return 0;
}

PLI_INT32 next_task(PLI_BYTE8* /*user*/) {
  std::vector<vpiHandle> arguments;
  if (!take_arguments("$biss_next", 5, arguments)) return 0;
  const Vector position = vector_of(arguments[2]);
  const Vector flags[] = {vector_of(arguments[3]), vector_of(arguments[4])};
  const bool known = position.known && flags[0].known && flags[1].known;
  biss_tb_next(
      text_of(arguments[0]).c_str(), number_of(arguments[1]), static_cast<long long>(position.bits),
      known ? static_cast<int>(flags[0].bits & 1U) : -1, static_cast<int>(flags[1].bits & 1U));
  return 0;
}

PLI_INT32 value_task(PLI_BYTE8* /*user*/) {
  std::vector<vpiHandle> arguments;
  if (!take_arguments("$biss_value", 5, arguments)) return 0;
  const Vector position = vector_of(arguments[2]);
  const Vector flags[] = {vector_of(arguments[3]), vector_of(arguments[4])};
  const bool known = position.known && flags[0].known && flags[1].known;
  biss_tb_value(text_of(arguments[0]).c_str(), number_of(arguments[1]),
                static_cast<long long>(position.bits), known ? 1 : 0,
                static_cast<int>(flags[0].bits & 1U), static_cast<int>(flags[1].bits & 1U));
  return 0;
}

PLI_INT32 compare_task(PLI_BYTE8* /*user*/) {
  std::vector<vpiHandle> arguments;
  if (!take_arguments("$biss_compare", 2, arguments)) return 0;
  biss_tb_compare(text_of(arguments[0]).c_str(), text_of(arguments[1]).c_str());
  return 0;
}

PLI_INT32 report_function(PLI_BYTE8* /*user*/) {
  std::vector<vpiHandle> arguments;
  if (!take_arguments("$biss_report", 1, arguments)) return 0;
  put_number(vpi_handle(vpiSysTfCall, nullptr), biss_tb_report(text_of(arguments[0]).c_str()));
  return 0;
}

PLI_INT32 report_size(PLI_BYTE8* /*user*/) { return 32; }

void register_task(const char* name, PLI_INT32 (*call)(PLI_BYTE8*)) {
  s_vpi_systf_data task{};
  task.type = vpiSysTask;
  task.tfname = name;
  task.calltf = call;
  vpi_register_systf(&task);
}

void register_all() {
  register_task("$biss_encoder", &encoder_task);
  register_task("$biss_master", &master_task);
  register_task("$biss_next", &next_task);
  register_task("$biss_value", &value_task);
  register_task("$biss_compare", &compare_task);
  s_vpi_systf_data function{};
  function.type = vpiSysFunc;
  function.sysfunctype = vpiIntFunc;
  function.tfname = "$biss_report";
  function.calltf = &report_function;
  function.sizetf = &report_size;
  vpi_register_systf(&function);
}

}  // namespace

extern "C" {
// The simulator finds it by this name.
[[gnu::visibility("default")]] void (*vlog_startup_routines[])() = {&register_all, nullptr};
}
