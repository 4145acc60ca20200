#include "live/control_socket.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

namespace biss::live {

namespace {

std::optional<sockaddr_un> address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return std::nullopt;
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

// \return the connected socket, or an error of errno, negative
int connect_to(const sockaddr_un& address) {
  const int client = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const auto* const to = reinterpret_cast<const sockaddr*>(&address);
  if (client >= 0 && ::connect(client, to, sizeof address) == 0) return client;
  const int error = errno;
  if (client >= 0) ::close(client);
  return -error;
}

bool is_of_owner(int client) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(client, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return false;
  return peer.uid == ::geteuid() || peer.uid == 0;
}

}  // namespace

ControlSocket::~ControlSocket() {
  for (const auto& [client, begin] : clients_) ::close(client);
  if (!path_.empty()) ::unlink(path_.c_str());
  if (socket_ >= 0) ::close(socket_);
  if (events_ >= 0) ::close(events_);
}

std::string ControlSocket::open(const std::string& path) {
  const auto address = address_of(path);
  if (!address) return fmt::format("{}: the path of a socket has at most 107 bytes", path);
  struct stat found {};
  if (::lstat(path.c_str(), &found) == 0) {
    if (!S_ISSOCK(found.st_mode)) return fmt::format("{}: exists and is not a socket", path);
    const int other = connect_to(*address);
    if (other >= 0) ::close(other);
    if (other != -ECONNREFUSED) {
      return fmt::format("{}: the socket is in use; end the other program, or give another path",
                         path);
    }
    ::unlink(path.c_str());
  }
  socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  events_ = ::epoll_create1(EPOLL_CLOEXEC);
  const mode_t before = ::umask(0177);
  const auto* const to = reinterpret_cast<const sockaddr*>(&*address);
  if (socket_ >= 0 && ::bind(socket_, to, sizeof *address) == 0) path_ = path;
  ::umask(before);
  epoll_event event{.events = EPOLLIN, .data = {.fd = socket_}};
  if (!path_.empty() && ::listen(socket_, 8) == 0 &&
      ::epoll_ctl(events_, EPOLL_CTL_ADD, socket_, &event) == 0) {
    return {};
  }
  return fmt::format("{}: {}", path, std::strerror(errno));
}

void ControlSocket::serve(const Answer& answer) {
  std::array<epoll_event, most_clients + 1> events{};
  const int count = ::epoll_wait(events_, events.data(), static_cast<int>(events.size()), 0);
  for (int k = 0; k < count; ++k) {
    const int ready = events[static_cast<std::size_t>(k)].data.fd;
    if (ready == socket_) {
      accept_client();
    } else if (!serve_client(ready, answer)) {
      clients_.erase(ready);
      ::close(ready);
    }
  }
}

void ControlSocket::accept_client() {
  const int client = ::accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (client < 0) return;
  epoll_event event{.events = EPOLLIN, .data = {.fd = client}};
  if (clients_.size() < most_clients && is_of_owner(client) &&
      ::epoll_ctl(events_, EPOLL_CTL_ADD, client, &event) == 0) {
    clients_[client];
  } else {
    ::close(client);
  }
}

bool ControlSocket::serve_client(int client, const Answer& answer) {
  std::array<char, 4096> block;
  const ssize_t got = ::recv(client, block.data(), block.size(), 0);
  if (got <= 0) return got < 0 && (errno == EAGAIN || errno == EINTR);
  std::string& text = clients_[client];
  text.append(block.data(), static_cast<std::size_t>(got));
  std::string answers;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    std::string_view line = std::string_view(text).substr(begin, end - begin);
    if (line.ends_with('\r')) line.remove_suffix(1);
    answers += answer(line) + '\n';
  }
  text.erase(0, begin);
  const bool too_long = text.size() > longest_line;
  if (too_long) answers += fmt::format("error: a line has at most {} bytes\n", longest_line);
  const ssize_t sent = ::send(client, answers.data(), answers.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return !too_long && sent == static_cast<ssize_t>(answers.size());
}

bool ask_control_socket(const std::string& path, const std::string& line, std::string& answer) {
  const auto address = address_of(path);
  const int server = address ? connect_to(*address) : -ENAMETOOLONG;
  if (server < 0) {
    answer =
        fmt::format("{}: {}; is biss emulate running with --ctl?", path, std::strerror(-server));
    return false;
  }
  const timeval limit{.tv_sec = 10, .tv_usec = 0};
  ::setsockopt(server, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  const std::string text = line + '\n';
  answer.clear();
  bool whole =
      ::send(server, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  for (char c = 0; whole && (whole = ::recv(server, &c, 1, 0) == 1) && c != '\n';) answer += c;
  ::close(server);
  if (!whole) answer = fmt::format("{}: no answer", path);
  return whole;
}

}  // namespace biss::live
