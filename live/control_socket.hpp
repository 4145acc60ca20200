// Commands for a running program, one a line, over a Unix socket that only its owner can use. Each
// line gets one line as its answer.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace biss::live {

class ControlSocket {
 public:
  using Answer = std::function<std::string(std::string_view line)>;
  static constexpr std::size_t most_clients = 16;
  static constexpr std::size_t longest_line = 1000;

  ControlSocket() = default;
  /// Closes all connections and removes the socket.
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

  /// Listens at this path; a socket that no program listens at is replaced. \return empty, or why it
  /// cannot
  std::string open(const std::string& path);
  /// Readable if there is something to serve; -1 if it is not open.
  int descriptor() const { return events_; }
  /// Answers the lines that are there, and never waits. Closes the connection of a client that does
  /// not read its answers, of another user, or with a line that is too long.
  void serve(const Answer& answer);

 private:
  void accept_client();
  bool serve_client(int client, const Answer& answer);

  std::string path_;
  int events_ = -1;
  int socket_ = -1;
  std::map<int, std::string> clients_;  // the begin of a line
};

/// Sends one line to such a socket and waits for the answer. \return false: `answer` is one line why
/// there is none
bool ask_control_socket(const std::string& path, const std::string& line, std::string& answer);

}  // namespace biss::live
