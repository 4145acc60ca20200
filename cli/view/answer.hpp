// The answers of `biss view` to requests, without the network.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "cli/view/served_capture.hpp"

namespace biss::cli {

/// The parts of a request that matter. A header that is missing, or present more than once, is
/// empty.
struct PageRequest {
  std::string_view method;
  std::string_view target;
  std::string_view host;
  std::string_view range;
};

/// Bytes of the capture.
struct ByteRange {
  std::uint64_t begin = 0;
  std::uint64_t size = 0;
};

struct PageAnswer {
  unsigned status = 0;
  std::string body = {};
  std::string type = "text/plain; charset=utf-8";
  /// In place of the body.
  std::optional<ByteRange> part = std::nullopt;
  std::string content_range = {};
  std::string location = {};
};

/// The page and the capture at secret addresses: the page at /TOKEN/, the capture at
/// /TOKEN/capture, its size in decimal at /TOKEN/size.
class ServedPage {
 public:
  /// \param capture outlives this
  /// \param page the text of the page for a capture of this size
  ServedPage(ServedCapture& capture, std::function<std::string(std::uint64_t size)> page);

  /// The server listens at this port of 127.0.0.1.
  void set_port(std::uint16_t port) { port_ = port; }
  std::string address() const;
  /// Leads to address(), once. For the arguments of a program, which all users of the machine see.
  std::string address_to_open() const;

  PageAnswer answer(const PageRequest& request);

 private:
  bool is_own_host(std::string_view host) const;
  PageAnswer give(std::string_view path, std::string_view range);
  PageAnswer give_capture(std::uint64_t size, std::string_view range) const;

  ServedCapture& capture_;
  std::function<std::string(std::uint64_t size)> page_;
  std::uint16_t port_ = 0;
  std::string token_;
  std::string opening_token_;
};

}  // namespace biss::cli
