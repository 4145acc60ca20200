#include "live/control_socket.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <thread>

#include "capture/test_folder.hpp"

namespace biss::live {
namespace control_socket_test {

using testing::HasSubstr;

class Sockets : public testing::Test {
 protected:
  // Until no client does anything for 50 ms.
  void serve() {
    pollfd waits{served.descriptor(), POLLIN, 0};
    while (::poll(&waits, 1, 50) == 1) {
      served.serve([this](std::string_view line) {
        lines.emplace_back(line);
        return answer.empty() ? "ok " + std::string(line) : answer;
      });
    }
  }
  int connect() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    const int client = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return client;
  }
  static void send(int client, const std::string& text) {
    EXPECT_EQ(::send(client, text.data(), text.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(text.size()));
  }
  static std::string receive(int client) {
    std::array<char, 4096> block{};
    const ssize_t got = ::recv(client, block.data(), block.size(), MSG_DONTWAIT);
    return got < 0 ? "nothing" : std::string(block.data(), static_cast<std::size_t>(got));
  }

  test::Folder folder;
  std::string path = folder.path("ctl");
  ControlSocket served;
  std::string answer;
  std::vector<std::string> lines;
};

TEST_F(Sockets, LinesInAnyPieces_AreAnswered) {
  ASSERT_EQ(served.open(path), "");
  struct stat found {};
  ASSERT_EQ(::stat(path.c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777U, 0600U);
  const int client = connect();
  send(client, "one\r\ntwo\nth");
  serve();
  EXPECT_EQ(receive(client), "ok one\nok two\n");
  send(client, "ree\n");
  serve();
  EXPECT_EQ(receive(client), "ok three\n");
  ::close(client);
  serve();
}

TEST_F(Sockets, OneLineOfTheCommand_GetsItsAnswer) {
  ASSERT_EQ(served.open(path), "");
  std::string got;
  bool done = false;
  std::thread asking([&] { done = ask_control_socket(path, "status", got); });
  while (lines.empty()) serve();
  asking.join();
  EXPECT_TRUE(done);
  EXPECT_EQ(got, "ok status");
  EXPECT_FALSE(ask_control_socket(folder.path("none"), "status", got));
  EXPECT_THAT(got, HasSubstr("is biss emulate running"));
  EXPECT_FALSE(ask_control_socket(std::string(200, 'x'), "status", got));
}

// It sends without end and reads nothing: the other client gets its answer.
TEST_F(Sockets, ClientThatDoesNotRead_IsDropped) {
  ASSERT_EQ(served.open(path), "");
  answer = std::string(100'000, 'x');
  const int deaf = connect();
  const int other = connect();
  for (int i = 0; i < 20; ++i) {
    if (::send(deaf, "status\n", 7, MSG_NOSIGNAL) < 0) break;
    serve();
  }
  EXPECT_LT(::send(deaf, "status\n", 7, MSG_NOSIGNAL), 0);
  answer = "ok";
  send(other, "status\n");
  serve();
  EXPECT_EQ(receive(other), "ok\n");
  ::close(deaf);
  ::close(other);
}

TEST_F(Sockets, LineWithoutEnd_IsRefused) {
  ASSERT_EQ(served.open(path), "");
  const int client = connect();
  send(client, std::string(3000, 'x'));
  serve();
  EXPECT_EQ(receive(client), "error: a line has at most 1000 bytes\n");
  EXPECT_EQ(receive(client), "");
  EXPECT_TRUE(lines.empty());
  ::close(client);
}

TEST_F(Sockets, TooManyClients_AreClosed) {
  ASSERT_EQ(served.open(path), "");
  std::vector<int> clients;
  for (std::size_t k = 0; k < ControlSocket::most_clients + 1; ++k) {
    clients.push_back(connect());
    serve();
  }
  EXPECT_EQ(receive(clients.back()), "");
  send(clients.front(), "a\n");
  serve();
  EXPECT_EQ(receive(clients.front()), "ok a\n");
  for (const int client : clients) ::close(client);
}

TEST_F(Sockets, PathThatIsTaken_IsRefusedAndAStaleSocketReplaced) {
  ASSERT_EQ(served.open(path), "");
  ControlSocket second;
  EXPECT_THAT(second.open(path), HasSubstr("in use"));
  ControlSocket third;
  EXPECT_THAT(third.open(folder.file("text", "x")), HasSubstr("not a socket"));
  EXPECT_THAT(third.open(folder.path("no/folder")), HasSubstr("No such file"));
  EXPECT_THAT(third.open(std::string(108, 'x')), HasSubstr("107 bytes"));
  const std::string stale = folder.path("stale");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  stale.copy(address.sun_path, sizeof address.sun_path - 1);
  const int dead = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(dead, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ::close(dead);
  {
    ControlSocket fourth;
    EXPECT_EQ(fourth.open(stale), "");
  }
  EXPECT_NE(::access(stale.c_str(), F_OK), 0);
}

}  // namespace control_socket_test
}  // namespace biss::live
