// `biss view` in a child process, and a client for its server.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <memory>

#include "tests/cli/run_command.hpp"

extern char** environ;

namespace biss::verbs::view_test {

const std::string page = R"(<body><script type="text/plain" id="biss-core">CORE</script></body>)";

// Longer than the server needs for an answer.
constexpr int timeout_milliseconds = 20'000;

class Client {
 public:
  explicit Client(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(port);
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  bool connected() const { return connected_; }
  void send(const std::string& text) const {
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t more = ::send(socket_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
      if (more <= 0) return;
      sent += static_cast<std::size_t>(more);
    }
  }
  void send_no_more() const { ::shutdown(socket_, SHUT_WR); }
  /// Closes the connection with a reset.
  void reset() const {
    const linger at_once{1, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  }
  /// To the end of the connection.
  std::string receive() const {
    std::string text;
    std::array<char, 65536> block{};
    pollfd waits{socket_, POLLIN, 0};
    while (::poll(&waits, 1, timeout_milliseconds) == 1) {
      const ssize_t got = ::recv(socket_, block.data(), block.size(), 0);
      if (got <= 0) break;
      text.append(block.data(), static_cast<std::size_t>(got));
    }
    return text;
  }

 private:
  int socket_;
  bool connected_ = false;
};

enum class Opening : std::uint8_t { none, browser };

/// `biss view` of a file, until the end of the test.
class Server {
 public:
  Server(const Folder& folder, const Words& arguments, Opening opening = Opening::none) {
    Words words{BISS_COMMAND, "view", "--page", folder.file("biss.html", page)};
    if (opening == Opening::none) words.emplace_back("--no-open");
    words = words + arguments;
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) return;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn(&child_, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    for (char c = 0; ::read(ends[0], &c, 1) == 1 && c != '\n';) address_ += c;
    ::close(ends[0]);
    // http://127.0.0.1:PORT/TOKEN/
    const std::size_t colon = address_.rfind(':');
    const std::size_t slash = address_.find('/', colon);
    if (slash == std::string::npos) return;
    port_ = static_cast<std::uint16_t>(std::stoi(address_.substr(colon + 1)));
    path_ = address_.substr(slash);
  }
  ~Server() { end(SIGKILL); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  const std::string& address() const { return address_; }
  const std::string& path() const { return path_; }
  std::uint16_t port() const { return port_; }
  std::string host() const { return fmt::format("127.0.0.1:{}", port_); }

  /// The whole answer to a request with this line and these headers.
  std::string ask(const std::string& line, const std::string& headers) const {
    const Client client(port_);
    client.send(line + " HTTP/1.1\r\n" + headers + "Connection: close\r\n\r\n");
    return client.receive();
  }
  std::string get(const std::string& below, const std::string& more = {}) const {
    return ask("GET " + path_ + below, "Host: " + host() + "\r\n" + more);
  }

  void signal(int number) const { ::kill(child_, number); }
  /// \return the exit status; 128 and the number of a signal that ended it
  int end(int signal) {
    if (child_ < 0) return -1;
    ::kill(child_, signal);
    int status = 0;
    ::waitpid(child_, &status, 0);
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t child_ = -1;
  std::string address_;
  std::string path_;
  std::uint16_t port_ = 0;
};

inline std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}

const std::string capture_text = "time_ns,MA,SLO\n0,1,1\n100,0,1\n2000,1,1\n";

}  // namespace biss::verbs::view_test
