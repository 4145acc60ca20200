// The figures of a watched link for Prometheus and MQTT.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "live/link_health.hpp"

namespace biss::cli {

struct PublishOptions {
  std::string listen;  ///< 127.0.0.1:PORT for Prometheus; empty: none
  std::string mqtt;    ///< HOST[:PORT] of a broker; empty: none
  std::string topic = "biss";
};

class Publisher {
 public:
  /// Throws a VerbError if the address is wrong or in use.
  Publisher(const PublishOptions& options, live::LinkUnit unit);
  ~Publisher();

  /// The figures that Prometheus gets until the next call.
  void set(const live::LinkHealth& health);
  /// A message for TOPIC/`below`. It never waits: a broker that does not take its messages gets no
  /// further ones.
  void send(std::string_view below, std::string_view json);
  /// Waits for the broker, for a second at most.
  /// \return the messages that it has not taken
  std::uint64_t finish();

 private:
  struct Metrics;
  struct Broker;
  std::unique_ptr<Metrics> metrics_;
  std::unique_ptr<Broker> broker_;
};

}  // namespace biss::cli
