#include "cli/view/answer.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <system_error>
#include <utility>

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

struct AskedRange {
  std::optional<std::uint64_t> first;
  std::optional<std::uint64_t> last;
};

std::optional<std::uint64_t> number_of(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// One range of bytes. Any other text is ignored, as RFC 9110 allows.
std::optional<AskedRange> range_of(std::string_view text) {
  constexpr std::string_view unit = "bytes=";
  if (!text.starts_with(unit)) return std::nullopt;
  text.remove_prefix(unit.size());
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view before = text.substr(0, dash);
  const std::string_view after = text.substr(dash + 1);
  const AskedRange range{number_of(before), number_of(after)};
  if (before.empty() ? !range.last : !range.first) return std::nullopt;
  if (!after.empty() && !range.last) return std::nullopt;
  if (range.first && range.last && *range.first > *range.last) return std::nullopt;
  return range;
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
  const auto asked = range_of(range);
  if (!asked) return answer;
  // The last bytes, or from the first one on.
  const std::uint64_t begin = asked->first ? *asked->first : size - std::min(size, *asked->last);
  const std::uint64_t end =
      asked->first && asked->last && *asked->last < size ? *asked->last + 1 : size;
  if (begin >= end) {
    answer = {416, "The capture ends before.\n"};
    answer.content_range = fmt::format("bytes */{}", size);
    return answer;
  }
  answer.status = 206;
  answer.part = ByteRange{begin, end - begin};
  answer.content_range = fmt::format("bytes {}-{}/{}", begin, end - 1, size);
  return answer;
}

}  // namespace biss::cli
