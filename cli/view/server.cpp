// The only file that includes Boost.Asio and Boost.Beast; compiled by itself.
#include "cli/view/server.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/status.hpp>
#include <chrono>
#include <csignal>
#include <list>
#include <optional>
#include <string_view>
#include <utility>

namespace biss::cli {

namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using boost::beast::flat_buffer;
using boost::system::error_code;
using tcp = asio::ip::tcp;
// This executor instead of asio::any_io_executor makes this file compile in two thirds of the time.
using Executor = asio::io_context::executor_type;
using Socket = asio::basic_stream_socket<tcp, Executor>;

// A browser opens six connections.
constexpr std::size_t connections_max = 32;
constexpr std::uint32_t header_bytes_max = 16384;
constexpr std::size_t block_bytes = std::size_t{256} << 10U;
// From the first byte of a request, or the end of the previous one, to its last byte.
constexpr std::chrono::seconds request_time{10};
// For each block.
constexpr std::chrono::seconds write_time{30};
constexpr std::chrono::milliseconds pause_after_failure{100};

std::string_view view_of(boost::beast::string_view text) { return {text.data(), text.size()}; }

using Header = http::request_header<>;

// Empty if the request has it more than once.
std::string_view only_value(const Header& header, http::field field) {
  if (header.count(field) != 1) return {};
  return view_of(header[field]);
}

// Every answer has these. The page itself contains its further policy.
constexpr std::string_view secure_fields =
    "Cache-Control: no-store\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "X-Frame-Options: DENY\r\n"
    "Content-Security-Policy: frame-ancestors 'none'\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n";

std::string header_of(const PageAnswer& answer, std::uint64_t length, bool goes_on) {
  const std::string_view reason =
      view_of(http::obsolete_reason(http::int_to_status(answer.status)));
  std::string text = fmt::format("HTTP/1.1 {} {}\r\n{}", answer.status, reason, secure_fields);
  const auto add = [&](std::string_view name, std::string_view value) {
    if (!value.empty()) text += fmt::format("{}: {}\r\n", name, value);
  };
  add("Content-Type", answer.type);
  add("Content-Length", std::to_string(length));
  add("Content-Range", answer.content_range);
  add("Location", answer.location);
  add("Allow", answer.status == 405 ? "GET, HEAD" : "");
  add("Accept-Ranges", answer.part ? "bytes" : "");
  add("Connection", goes_on ? "" : "close");
  return text + "\r\n";
}

// One request after the other.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Socket socket, ServedPage& page, const ServedCapture& capture)
      : stream_(std::move(socket)), page_(page), capture_(capture) {}

  bool waits() const { return waits_; }
  void close() { stream_.close(); }

  void read() {
    parser_.emplace();
    parser_->header_limit(header_bytes_max);
    left_of_header_ = header_bytes_max - buffer_.size();
    waits_ = true;
    stream_.expires_after(request_time);
    parse();
  }

 private:
  // The limit of the parser is for the bytes that it has not taken yet, so the bytes are counted here.
  void parse() {
    error_code problem;
    buffer_.consume(parser_->put(buffer_.data(), problem));
    if (problem != http::error::need_more || left_of_header_ == 0) return take(problem);
    stream_.async_read_some(buffer_.prepare(left_of_header_),
                            [self = shared_from_this()](error_code failed, std::size_t got) {
                              if (failed) return;
                              self->buffer_.commit(got);
                              self->left_of_header_ -= got;
                              self->parse();
                            });
  }

  void take(error_code problem) {
    waits_ = false;
    const Header& header = parser_->get();
    const std::string_view method = view_of(header.method_string());
    // The end of a body in a coding other than `chunked` is unknown.
    if (problem || (parser_->is_done() && header.count(http::field::transfer_encoding) != 0)) {
      send({400, "This is not an HTTP request.\n"}, method == "HEAD", false);
      return;
    }
    // No answer has a validator, so the condition of If-Range is never true.
    const std::string_view range = header.count(http::field::if_range) == 0
                                       ? only_value(header, http::field::range)
                                       : std::string_view{};
    const PageAnswer answer = page_.answer(
        {method, view_of(header.target()), only_value(header, http::field::host), range});
    // After a request with a body, further bytes are ignored.
    const bool goes_on = parser_->is_done() && parser_->keep_alive() && answer.status < 400;
    send(answer, method == "HEAD", goes_on);
  }

  void send(const PageAnswer& answer, bool head_only, bool goes_on) {
    goes_on_ = goes_on;
    const ByteRange part = answer.part.value_or(ByteRange{});
    text_ = header_of(answer, answer.part ? part.size : answer.body.size(), goes_on);
    if (!head_only) text_ += answer.body;
    place_ = part.begin;
    left_ = head_only ? 0 : part.size;
    write();
  }

  void write() {
    if (text_.empty() && left_ > 0) {
      text_ = capture_.text_at(
          place_, static_cast<std::size_t>(std::min<std::uint64_t>(left_, block_bytes)));
      // The length has been sent: an end before it is the only sign left.
      if (text_.empty()) return close();
      place_ += text_.size();
      left_ -= text_.size();
    }
    if (text_.empty()) return finish();
    stream_.expires_after(write_time);
    asio::async_write(stream_, asio::buffer(text_),
                      [self = shared_from_this()](error_code failed, std::size_t) {
                        if (failed) return;
                        self->text_.clear();
                        self->write();
                      });
  }

  void finish() {
    if (goes_on_) return read();
    error_code ignored;
    stream_.socket().shutdown(Socket::shutdown_send, ignored);
    waits_ = true;
    stream_.expires_after(request_time);
    buffer_.clear();
    drain();
  }

  // To close with bytes that are not read resets the connection, and the client loses the rest of
  // the answer.
  void drain() {
    stream_.async_read_some(buffer_.prepare(header_bytes_max),
                            [self = shared_from_this()](error_code failed, std::size_t) {
                              if (!failed) self->drain();
                            });
  }

  boost::beast::basic_stream<tcp, Executor> stream_;
  ServedPage& page_;
  const ServedCapture& capture_;
  flat_buffer buffer_{header_bytes_max};
  std::size_t left_of_header_ = 0;
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::string text_;
  std::uint64_t place_ = 0;
  std::uint64_t left_ = 0;
  bool goes_on_ = false;
  bool waits_ = false;
};

class Server {
 public:
  Server(ServedPage& page, const ServedCapture& capture) : page_(page), capture_(capture) {}

  error_code listen(std::uint16_t port) try {
    const tcp::endpoint place(asio::ip::address_v4::loopback(), port);
    acceptor_.open(place.protocol());
    // A port that was in use a moment ago.
    if (port != 0) acceptor_.set_option(tcp::acceptor::reuse_address(true));
    acceptor_.bind(place);
    acceptor_.listen();
    // The browser is started from here.
    ::fcntl(acceptor_.native_handle(), F_SETFD, FD_CLOEXEC);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) signals_.add(number);
    page_.set_port(acceptor_.local_endpoint().port());
    return {};
  } catch (const boost::system::system_error& problem) {
    return problem.code();
  }

  void run() {
    signals_.async_wait([this](error_code problem, int) {
      if (!problem) context_.stop();
    });
    accept();
    context_.run();
  }

 private:
  void accept() {
    acceptor_.async_accept([this](error_code problem, Socket socket) {
      if (problem) return accept_later();
      take(std::move(socket));
      accept();
    });
  }

  // For example, no descriptor is left.
  void accept_later() {
    timer_.expires_after(pause_after_failure);
    timer_.async_wait([this](error_code problem) {
      if (!problem) accept();
    });
  }

  // If there are too many, the connection that has been idle longest is closed.
  void take(Socket socket) {
    connections_.remove_if([](const auto& each) { return each.expired(); });
    if (connections_.size() >= connections_max) {
      const auto idle =
          std::find_if(connections_.begin(), connections_.end(), [](const auto& each) {
            const auto held = each.lock();
            return held && held->waits();
          });
      if (idle == connections_.end()) return;
      if (const auto held = idle->lock()) held->close();
      connections_.erase(idle);
    }
    const auto made = std::make_shared<Connection>(std::move(socket), page_, capture_);
    connections_.push_back(made);
    made->read();
  }

  ServedPage& page_;
  const ServedCapture& capture_;
  asio::io_context context_{1};
  asio::basic_socket_acceptor<tcp, Executor> acceptor_{context_};
  asio::basic_waitable_timer<std::chrono::steady_clock,
                             asio::wait_traits<std::chrono::steady_clock>, Executor>
      timer_{context_};
  asio::signal_set signals_{context_};
  std::list<std::weak_ptr<Connection>> connections_;
};

}  // namespace

std::string serve(ServedPage& page, const ServedCapture& capture, std::uint16_t port,
                  const std::function<bool()>& on_listening) {
  Server server(page, capture);
  if (const error_code problem = server.listen(port)) {
    return fmt::format("cannot listen at 127.0.0.1{}: {}",
                       port == 0 ? "" : fmt::format(":{}", port), problem.message());
  }
  if (on_listening()) server.run();
  return {};
}

}  // namespace biss::cli
