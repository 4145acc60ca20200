#include "cli/live/publish.hpp"

#include <fmt/format.h>
#include <mosquitto.h>
#include <prometheus/counter.h>
#include <prometheus/exposer.h>
#include <prometheus/gauge.h>
#include <prometheus/registry.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <map>
#include <optional>
#include <thread>
#include <tuple>

#include "report/text.hpp"
#include "verbs/common/host.hpp"

namespace biss::cli {

using namespace live;

struct Publisher::Metrics {
  Metrics(const std::string& address, LinkUnit unit)
      // A connection without a request must not block the others.
      : exposer({"listening_ports", address, "num_threads", "4", "request_timeout_ms", "2000"}),
        is_clock(unit == LinkUnit::clock) {
    exposer.RegisterCollectable(registry);
  }

  using Labels = std::map<std::string, std::string>;

  void count(const char* name, const char* help, const Labels& labels, std::uint64_t value) {
    auto& counter =
        prometheus::BuildCounter().Name(name).Help(help).Register(*registry).Add(labels);
    counter.Increment(static_cast<double>(value) - counter.Value());
  }
  void gauge(const std::string& name, const char* help, const Labels& labels, double value) {
    prometheus::BuildGauge().Name(name).Help(help).Register(*registry).Add(labels).Set(value);
  }

  void set(const LinkHealth& health) {
    const HealthState& state = health.state();
    for (std::size_t k = 0; k < cycle_status_count; ++k) {
      count("biss_cycles_total", "Request cycles by status.",
            {{"status", std::string(cycle_status_names[k])}}, state.counts.by_status[k]);
    }
    count("biss_error_frames_total", "Good frames in which nE is active.", {}, state.counts.errors);
    count("biss_warning_frames_total", "Good frames in which nW is active.", {},
          state.counts.warnings);
    for (std::size_t k = 0; k < alarm_count; ++k) {
      gauge("biss_alarm", "1 while the alarm is on.",
            {{"alarm", std::string(name_of(static_cast<Alarm>(k)))}},
            state.reasons[k].empty() ? 0 : 1);
    }
    if (state.recent.empty()) return;
    const HealthPoint& last = state.recent.back();
    gauge("biss_last_interval_timestamp_seconds", "Begin of the last interval.", {},
          static_cast<double>(last.time));
    const std::string end = is_clock ? "clocks" : "seconds";
    const double time = is_clock ? 1 : 1e-12;
    for (const auto& [level, name, help, unit] :
         {std::tuple(Level::delay, "line_delay_" + end, "Median line delay of the last interval.",
                     time),
          std::tuple(Level::ack, "ack_" + end, "Median ACK of the last interval.", time),
          std::tuple(
              Level::margin, std::string("margin_ratio"),
              "Distance from the sampling point to the next change of SLO, in periods of MA.",
              1e-3)}) {
      const auto value = last.level(level);
      if (value) gauge("biss_" + name, help, {}, static_cast<double>(*value) * unit);
    }
  }

  prometheus::Exposer exposer;
  std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
  bool is_clock;
};

struct Publisher::Broker {
  static constexpr std::uint64_t waiting_max = 1000;

  Broker(std::string name, int number) : host(std::move(name)), port(number) {
    ::mosquitto_lib_init();
    client = ::mosquitto_new(nullptr, true, this);
    ::mosquitto_publish_callback_set(
        client, [](mosquitto*, void* self, int) { ++static_cast<Broker*>(self)->taken; });
    ::mosquitto_reconnect_delay_set(client, 1, 10, true);
    connect();
  }
  // Until the broker takes the first connection; later ones are made by the library.
  void connect() {
    if (connected || Clock::now() < next) return;
    next = Clock::now() + std::chrono::seconds(1);
    if (::mosquitto_connect_async(client, host.c_str(), port, 30) != MOSQ_ERR_SUCCESS) return;
    connected = true;
    ::mosquitto_loop_start(client);
  }
  ~Broker() {
    ::mosquitto_disconnect(client);
    ::mosquitto_loop_stop(client, true);
    ::mosquitto_destroy(client);
    ::mosquitto_lib_cleanup();
  }

  using Clock = std::chrono::steady_clock;
  std::string host;
  int port;
  bool connected = false;
  Clock::time_point next{};
  mosquitto* client = nullptr;
  std::string topic;
  std::uint64_t sent = 0;
  std::uint64_t dropped = 0;
  std::atomic<std::uint64_t> taken = 0;
};

Publisher::Publisher(const PublishOptions& options, LinkUnit unit) {
  const auto port_of = [](const char* option, const std::string& address, std::size_t colon) {
    const auto port = report::number_in<std::uint16_t>(std::string_view(address).substr(colon + 1));
    if (!port) throw verbs::wrong_usage("{} '{}': the port is not a number", option, address);
    return *port;
  };
  if (const std::string& address = options.listen; !address.empty()) {
    if (!address.starts_with("127.0.0.1:") && !address.starts_with("localhost:")) {
      throw verbs::wrong_usage("--listen '{}': write 127.0.0.1:PORT", address);
    }
    const int port = port_of("--listen", address, address.find(':'));
    try {
      metrics_ = std::make_unique<Metrics>(fmt::format("127.0.0.1:{}", port), unit);
    } catch (const std::exception&) {
      throw verbs::wrong_file("--listen {}: another program uses the port, or it may not be used",
                              address);
    }
  }
  if (options.mqtt.empty()) return;
  const std::size_t colon = options.mqtt.rfind(':');
  const int port = colon == std::string::npos ? 1883 : port_of("--mqtt", options.mqtt, colon);
  const std::string broker = options.mqtt.substr(0, colon);
  if (broker.empty() || port == 0 || broker.find_first_of(":/[") != std::string::npos) {
    throw verbs::wrong_usage("--mqtt '{}': write HOST or HOST:PORT", options.mqtt);
  }
  if (options.topic.find_first_of("#+") != std::string::npos) {
    throw verbs::wrong_usage("--topic '{}': # and + cannot be in a topic", options.topic);
  }
  broker_ = std::make_unique<Broker>(broker, port);
  broker_->topic = options.topic;
}

Publisher::~Publisher() = default;

void Publisher::set(const LinkHealth& health) {
  if (broker_) broker_->connect();
  if (metrics_) metrics_->set(health);
}

void Publisher::send(std::string_view below, std::string_view json) {
  if (!broker_) return;
  if (broker_->sent - broker_->taken >= Broker::waiting_max) {
    ++broker_->dropped;
    return;
  }
  ++broker_->sent;
  const std::string topic = fmt::format("{}/{}", broker_->topic, below);
  // At least once; the last message stays for those who come later.
  ::mosquitto_publish(broker_->client, nullptr, topic.c_str(), static_cast<int>(json.size()),
                      json.data(), 1, true);
}

std::uint64_t Publisher::finish() {
  if (!broker_) return 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  while (broker_->taken < broker_->sent && std::chrono::steady_clock::now() < end) {
    broker_->connect();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return broker_->sent - broker_->taken + broker_->dropped;
}

}  // namespace biss::cli
