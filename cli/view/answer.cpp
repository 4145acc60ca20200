#include "cli/view/answer.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "report/text.hpp"

namespace biss::cli {

namespace {

constexpr std::size_t token_bytes = 16;

// getrandom() returns this few bytes in one call, or fails.
std::string random_token() {
  std::array<unsigned char, token_bytes> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("the system gives no random numbers");
  }
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

// Takes the same time for any difference.
bool same_token(std::string_view given, std::string_view token) {
  return !token.empty() && given.size() == token.size() &&
         CRYPTO_memcmp(given.data(), token.data(), token.size()) == 0;
}

// The part of the capture that a header `Range` names. Nothing for any other text than one range of
// bytes, which is ignored, as RFC 9110 allows. An empty part: the range begins after the end.
std::optional<ByteRange> range_of(std::string_view text, std::uint64_t size) {
  constexpr std::string_view unit = "bytes=";
  const std::size_t dash = text.find('-');
  if (!text.starts_with(unit) || dash == std::string_view::npos) return std::nullopt;
  const std::string_view before = text.substr(unit.size(), dash - unit.size());
  const std::string_view after = text.substr(dash + 1);
  const auto first = report::number_in<std::uint64_t>(before);
  const auto last = report::number_in<std::uint64_t>(after);
  if ((!first && !before.empty()) || (!last && !after.empty())) return std::nullopt;
  if (!first && !last) return std::nullopt;
  // The last bytes.
  if (!first) return ByteRange{size - std::min(size, *last), std::min(size, *last)};
  if (last.value_or(*first) < *first) return std::nullopt;
  if (*first >= size) return ByteRange{size, 0};
  return ByteRange{*first, std::min(size - 1, last.value_or(size - 1)) - *first + 1};
}

}  // namespace

ServedPage::ServedPage(ServedCapture& capture, std::function<std::string(std::uint64_t size)> page)
    : capture_(capture),
      page_(std::move(page)),
      token_(random_token()),
      opening_token_(random_token()) {}

std::string ServedPage::address() const {
  return fmt::format("http://127.0.0.1:{}/{}/", port_, token_);
}

std::string ServedPage::address_to_open() const {
  return fmt::format("http://127.0.0.1:{}/{}", port_, opening_token_);
}

// A foreign page whose name resolves to this machine has another Host.
bool ServedPage::is_own_host(std::string_view host) const {
  const auto is = [&](std::string_view name) {
    return host == fmt::format("{}:{}", name, port_) || (port_ == 80 && host == name);
  };
  return is("127.0.0.1") || is("localhost");
}

PageAnswer ServedPage::answer(const PageRequest& request) {
  if (!is_own_host(request.host)) return {403, "This server is known by another name.\n"};
  std::string_view path = request.target;
  const bool begins = path.starts_with('/');
  if (begins) path.remove_prefix(1);
  const std::size_t slash = std::min(path.find('/'), path.size());
  const std::string_view token = path.substr(0, slash);
  const bool opens = begins && slash == path.size() && same_token(token, opening_token_);
  if (!opens && (!begins || !same_token(token, token_))) {
    return {403, "This address does not have the token that biss view printed.\n"};
  }
  if (request.method != "GET" && request.method != "HEAD") {
    return {405, "Only GET and HEAD.\n"};
  }
  if (opens) {
    if (request.method == "GET") opening_token_.clear();
    PageAnswer answer{303};
    answer.location = fmt::format("/{}/", token_);
    return answer;
  }
  return give(path.substr(slash), request.method == "GET" ? request.range : std::string_view{});
}

PageAnswer ServedPage::give(std::string_view path, std::string_view range) {
  if (path != "/" && path != "/capture" && path != "/size") return {404, "Not here.\n"};
  const auto size = capture_.look(path != "/capture");
  if (path == "/") {
    // The page shows the error when it requests the capture.
    return {200, page_(size.value_or(0)), "text/html; charset=utf-8"};
  }
  if (!size) return {410, size.error()};
  if (path == "/size") return {200, fmt::format("{}", *size)};
  return give_capture(*size, range);
}

PageAnswer ServedPage::give_capture(std::uint64_t size, std::string_view range) const {
  PageAnswer answer{200, {}, "application/octet-stream", ByteRange{0, size}};
  const auto asked = range_of(range, size);
  if (!asked) return answer;
  if (asked->size == 0) {
    answer = {416, "The capture ends before.\n"};
    answer.content_range = fmt::format("bytes */{}", size);
    return answer;
  }
  answer.status = 206;
  answer.part = asked;
  answer.content_range =
      fmt::format("bytes {}-{}/{}", asked->begin, asked->begin + asked->size - 1, size);
  return answer;
}

}  // namespace biss::cli
