// Hostile requests to the server of `biss view`, and clients and files that change in an answer.
#include "tests/cli/view_server.hpp"

namespace biss::verbs::view_test {

using HostileView = InFolder;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// HOST stands for the name of the server with its PORT, PATH for /TOKEN/.
struct Hostile {
  const char* situation;
  std::string request;
  // The status of each answer, and the length of 200 and 206. Then the server ends the connection.
  std::string answers;
};

std::string with_target(const std::string& target) {
  return "GET " + target + " HTTP/1.1\r\nHost: HOST\r\n\r\n";
}
std::string with_headers(const std::string& headers, const std::string& body = {}) {
  return "GET PATHcapture HTTP/1.1\r\n" + headers + "\r\n" + body;
}
std::string with(const std::string& header, const std::string& body = {}) {
  return with_headers("Host: HOST\r\n" + header + "\r\n", body);
}
const std::string capture_too = with_headers("Host: HOST\r\n");
const std::string size_too = "GET PATHsize HTTP/1.1\r\nHost: HOST\r\n\r\n";

std::vector<Hostile> targets() {
  return {
      {"nothing", "", ""},
      {"token twice", with_target("PATHTOKEN/capture"), "404"},
      {"longer token", with_target("/TOKEN0/capture"), "403"},
      {"token in the query", with_target("/?TOKEN"), "403"},
      {"token in the second part", with_target("/x/TOKEN/capture"), "403"},
      {"token and parameter", with_target("/TOKEN;/capture"), "403"},
      {"token and fragment", with_target("/TOKEN#/capture"), "403"},
      {"token and NUL, encoded", with_target("/TOKEN%00/capture"), "403"},
      {"token after a dot segment", with_target("/x/../TOKEN/capture"), "403"},
      {"token in headers", "GET /capture HTTP/1.1\r\nHost: HOST\r\nCookie: TOKEN\r\n\r\n", "403"},
      {"token without a slash", with_target("/TOKEN"), "404"},
      {"absolute form", with_target("http://HOSTPATHcapture"), "403"},
      {"authority form", "CONNECT HOST HTTP/1.1\r\nHost: HOST\r\n\r\n", "403"},
      {"asterisk form", "OPTIONS * HTTP/1.1\r\nHost: HOST\r\n\r\n", "403"},
      {"asterisk", with_target("*"), "403"},
      {"double encoding", with_target("PATH%252e%252e/secret"), "404"},
      {"encoded slash", with_target("PATH..%2fsecret"), "404"},
      {"backslash", with_target("PATH..\\secret"), "404"},
      {"encoded backslash", with_target("PATH..%5csecret"), "404"},
      {"overlong UTF-8", with_target("PATH\xc0\xae\xc0\xae/secret"), "404"},
      {"file of the system", with_target("PATH/etc/passwd"), "404"},
      {"dot segment", with_target("PATH./capture"), "404"},
      {"encoded letter", with_target("PATH%63apture"), "404"},
      {"fragment", with_target("PATHcapture#x"), "404"},
      {"NUL", with_target(std::string("PATHcapture\0", 12)), "400"},
      {"DEL", with_target("PATHcapture\x7f"), "400"},
      {"blank", with_target("PATH capture"), "400"},
      {"TAB", with_target("PATH\tcapture"), "400"},
      {"no target", with_target(""), "400"},
      {"long target", with_target("PATH" + std::string(8000, 'a')), "404"},
      {"target without end", "GET PATH" + std::string(17'000, 'a'), "400"},
      {"method in small letters", "get PATHcapture HTTP/1.1\r\nHost: HOST\r\n\r\n", "405"},
      {"long method", std::string(8000, 'A') + " PATH HTTP/1.1\r\nHost: HOST\r\n\r\n", "405"},
      {"method without end", std::string(17'000, 'A'), "400"},
      {"no method", " PATHcapture HTTP/1.1\r\nHost: HOST\r\n\r\n", "400"},
      {"TRACE", "TRACE PATH HTTP/1.1\r\nHost: HOST\r\n\r\n", "405"},
      {"HTTP/1.0", "GET PATHcapture HTTP/1.0\r\nHost: HOST\r\n\r\n", "200/38"},
      {"HTTP/1.0 without Host", "GET PATHcapture HTTP/1.0\r\n\r\n", "403"},
      {"HTTP/0.9", "GET PATHcapture\r\n", "400"},
      {"HTTP/2.0", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", "400"},
      {"HTTP/1.2", "GET PATHcapture HTTP/1.2\r\nHost: HOST\r\n\r\n", "400"},
      {"http", "GET PATHcapture http/1.1\r\nHost: HOST\r\n\r\n", "400"},
      {"blank after the version", "GET PATHcapture HTTP/1.1 \r\nHost: HOST\r\n\r\n", "400"},
  };
}

std::vector<Hostile> hosts() {
  return {
      {"empty", with_headers("Host:\r\n"), "403"},
      {"other port", with_headers("Host: 127.0.0.1:1\r\n"), "403"},
      {"longer port", with_headers("Host: HOST0\r\n"), "403"},
      {"port with a zero", with_headers("Host: 127.0.0.1:0PORT\r\n"), "403"},
      {"IPv6", with_headers("Host: [::1]:PORT\r\n"), "403"},
      {"IPv4 in IPv6", with_headers("Host: [::ffff:127.0.0.1]:PORT\r\n"), "403"},
      {"any address", with_headers("Host: 0.0.0.0:PORT\r\n"), "403"},
      {"short address", with_headers("Host: 127.1:PORT\r\n"), "403"},
      {"address as a number", with_headers("Host: 2130706433:PORT\r\n"), "403"},
      {"name of another for this address", with_headers("Host: 127.0.0.1.evil:PORT\r\n"), "403"},
      {"name below localhost", with_headers("Host: evil.localhost:PORT\r\n"), "403"},
      {"dot at the end", with_headers("Host: localhost.:PORT\r\n"), "403"},
      {"user", with_headers("Host: evil@HOST\r\n"), "403"},
      {"two names", with_headers("Host: HOST, evil\r\n"), "403"},
      {"twice", with_headers("Host: HOST\r\nhost: evil\r\n"), "403"},
      {"other header", with_headers("Host: evil\r\nX-Forwarded-Host: HOST\r\n"), "403"},
      {"blank before the colon", with_headers("Host : HOST\r\n"), "400"},
      {"NUL", with_headers(std::string("Host: HOST\0\r\n", 13)), "400"},
      {"folded", with_headers("Host:\r\n\tHOST \t\r\n"), "200/38"},
  };
}

std::vector<Hostile> headers() {
  std::string thousands;
  for (int i = 0; i < 3000; ++i) thousands += "A: 1\r\n";
  return {
      {"LF alone", "GET PATHcapture HTTP/1.1\nHost: HOST\n\n", "400"},
      {"CR alone", "GET PATHcapture HTTP/1.1\rHost: HOST\r\r", "400"},
      {"LF in a header", with("X: a\nY: b"), "400"},
      {"CR in a header", with("X: a\rY: b"), "400"},
      {"no end of the headers", "GET PATHcapture HTTP/1.1\r\nHost: HOST\r\n", ""},
      {"line before the request", "\r\n" + capture_too, "400"},
      {"no colon", with("Range"), "400"},
      {"no name", with(": x"), "400"},
      {"blank in a name", with("X Y: a"), "400"},
      {"control character in a name", with("X\x01: a"), "400"},
      {"NUL in a value", with(std::string("X: \0", 4)), "400"},
      {"letters of other sets", with("X: \xe4\xff"), "200/38"},
      {"folded", with("X: a\r\n b"), "200/38"},
      {"folded first", with_headers(" X: a\r\nHost: HOST\r\n"), "400"},
      {"large", with("X: " + std::string(15'000, 'x')), "200/38"},
      {"too large", with("X: " + std::string(17'000, 'x')), "400"},
      {"long name", with(std::string(17'000, 'X') + ": a"), "400"},
      {"hundreds of fields", with(thousands.substr(0, 5998)), "200/38"},
      {"thousands of fields", with(thousands + "B: 1"), "400"},
      {"wrong Connection", with("Connection: ,;,"), "400"},
      {"Expect", with("Expect: 100-continue"), "200/38"},
      {"Upgrade", with("Connection: Upgrade\r\nUpgrade: h2c"), "200/38"},
      {"Range without a value", with("Range:"), "200/38"},
      {"Range without a number", with("Range: bytes="), "200/38"},
      {"Range with a sign", with("Range: bytes=+1-2"), "200/38"},
      {"Range with blanks", with("Range: bytes= 1-2"), "200/38"},
      {"Range in base 16", with("Range: bytes=0x1-2"), "200/38"},
      {"Range of three numbers", with("Range: bytes=1-2-3"), "200/38"},
      {"Range in other units", with("Range: lines=1-2"), "200/38"},
      {"ranges that overlap", with("Range: bytes=0-5,3-9"), "200/38"},
      {"hundreds of ranges", with("Range: bytes=0-0" + std::string(900, ',')), "200/38"},
      {"Range twice", with("Range: bytes=0-0\r\nRange: bytes=1-1"), "200/38"},
      {"Range if unchanged", with("Range: bytes=0-0\r\nIf-Range: \"1\""), "200/38"},
  };
}

// Bytes after the header are a body, which the server ignores, or the next request.
std::vector<Hostile> bodies() {
  std::string hundreds;
  std::string answers;
  for (int i = 0; i < 300; ++i, answers += "206/1 ") hundreds += with("Range: bytes=0-0");
  return {
      {"pipelined", with("Range: bytes=3-4") + size_too + capture_too, "206/2 200/2 200/38"},
      {"empty body", with("Content-Length: 0", size_too), "200/38 200/2"},
      {"empty body twice", with("Content-Length: 0, 0", size_too), "200/38 200/2"},
      {"body", with("Content-Length: 90", size_too), "200/38"},
      {"body that ends early", with("Content-Length: 900", size_too), "200/38"},
      {"body of POST", "POST" + with("Content-Length: 90", size_too).substr(3), "405"},
      {"huge body", with("Content-Length: 9999999999", size_too), "400"},
      {"length in base 16", with("Content-Length: 0x0", size_too), "400"},
      {"length with a sign", with("Content-Length: +0", size_too), "400"},
      {"length beyond 64 bits", with("Content-Length: 18446744073709551616", size_too), "400"},
      {"two lengths", with("Content-Length: 0\r\nContent-Length: 90", size_too), "400"},
      {"list of lengths", with("Content-Length: 0, 90", size_too), "400"},
      {"chunks", with("Transfer-Encoding: chunked", "0\r\n\r\n" + size_too), "200/38"},
      {"wrong chunks", with("Transfer-Encoding: chunked", "-1\r\n" + size_too), "200/38"},
      {"chunks and length",
       with("Transfer-Encoding: chunked\r\nContent-Length: 0", "0\r\n\r\n" + size_too), "400"},
      {"length and chunks", with("Content-Length: 0\r\nTransfer-Encoding: chunked", size_too),
       "400"},
      {"coding that is not chunked", with("Transfer-Encoding: gzip", size_too), "400"},
      {"chunked, but not at last", with("Transfer-Encoding: chunked, gzip", size_too), "400"},
      {"chunked after a VT",
       with("Transfer-Encoding:\x0b"
            "chunked",
            size_too),
       "400"},
      {"chunked as a part", with("Transfer-Encoding: xchunked", size_too), "400"},
      {"request after the last one", with("Connection: close") + size_too, "200/38"},
      {"request after a refused one", with_target("/") + size_too, "403"},
      {"noise after a request", capture_too + "\x16\x03\x01 " + size_too, "200/38 400"},
      {"HEAD, pipelined", "HEAD" + capture_too.substr(3) + size_too, "200/38 200/2"},
      {"hundreds, pipelined", hundreds + "x\r\n", answers + "400"},
  };
}

std::string answers_in(const std::string& text) {
  constexpr std::string_view begins = "HTTP/1.1 ";
  constexpr std::string_view length = "\r\nContent-Length: ";
  std::string found;
  for (std::size_t at = 0; (at = text.find(begins, at)) != std::string::npos;) {
    at += begins.size();
    if (!found.empty()) found += ' ';
    found += text.substr(at, 3);
    if (text[at] != '2') continue;
    const std::size_t number = text.find(length, at) + length.size();
    found += '/' + text.substr(number, text.find('\r', number) - number);
  }
  return found;
}

std::string filled_in(const Server& server, std::string text) {
  const std::string token = server.path().substr(1, server.path().size() - 2);
  for (const auto& [name, value] :
       {std::pair{std::string("PATH"), server.path()}, std::pair{std::string("TOKEN"), token},
        std::pair{std::string("HOST"), server.host()},
        std::pair{std::string("PORT"), fmt::format("{}", server.port())}}) {
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += value.size()) {
      text.replace(at, name.size(), value);
    }
  }
  return text;
}

TEST_F(HostileView, EachRequest_HasItsAnswerAndTheNextOneToo) {
  folder.file("secret", "secret");
  const Server server(folder, {folder.file("a.csv", capture_text)});
  for (const auto& table : {targets(), hosts(), headers(), bodies()}) {
    for (const Hostile& hostile : table) {
      const Client client(server.port());
      client.send(filled_in(server, hostile.request));
      client.send_no_more();
      const std::string received = client.receive();
      EXPECT_EQ(answers_in(received), hostile.answers) << hostile.situation;
      EXPECT_THAT(received, Not(HasSubstr("secret"))) << hostile.situation;
      if (hostile.answers.find("200/38") == std::string::npos) {
        EXPECT_THAT(received, Not(HasSubstr("time"))) << hostile.situation;
      }
      EXPECT_EQ(body_of(server.get("capture")), capture_text) << hostile.situation;
    }
  }
}

TEST_F(HostileView, WrongHead_HasNoBody) {
  const Server server(folder, {folder.file("a.csv", capture_text)});
  for (const char* const wrong : {"Transfer-Encoding: gzip\r\n", "no colon\r\n", ""}) {
    const std::string answer = server.ask("HEAD " + server.path() + "x", wrong);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 40")) << wrong;
    EXPECT_EQ(body_of(answer), "") << wrong;
  }
}

// If each piece ends after the first byte of a field, the parser takes all fields before.
TEST_F(HostileView, HeaderWithoutEndInPieces_IsRefused) {
  const Server server(folder, {folder.file("a.csv", capture_text)});
  const Client client(server.port());
  client.send("GET / HTTP/1.1\r\nA");
  for (int i = 0; i < 50; ++i, ::usleep(2000)) client.send("b: " + std::string(480, 'x') + "\r\nA");
  client.send_no_more();
  EXPECT_THAT(client.receive(), StartsWith("HTTP/1.1 400 "));
}

TEST_F(HostileView, SingleBytes_AreARequest) {
  const Server server(folder, {folder.file("a.csv", capture_text)});
  const Client client(server.port());
  for (const char c : filled_in(server, with("Connection: close"))) {
    client.send(std::string(1, c));
    ::usleep(1000);
  }
  EXPECT_EQ(body_of(client.receive()), capture_text);
}

std::string large_capture() { return capture_text + std::string(16U << 20U, '\n'); }

TEST_F(HostileView, BytesAfterTheLastRequest_DoNotCutItsAnswer) {
  const std::string large = large_capture();
  const Server server(folder, {folder.file("large.csv", large)});
  for (const std::string& request : {with("Content-Length: 90000", std::string(90'000, 'x')),
                                     with("Connection: close", std::string(90'000, 'x'))}) {
    const Client client(server.port());
    client.send(filled_in(server, request));
    EXPECT_EQ(body_of(client.receive()).size(), large.size());
  }
}

TEST_F(HostileView, ResetInAnAnswer_DoesNotDisturbAnother) {
  const std::string large = large_capture();
  const Server server(folder, {folder.file("large.csv", large)});
  const std::string request = filled_in(server, with("Connection: close"));
  const Client other(server.port());
  other.send(request);
  for (int i = 0; i < 40; ++i) {
    const Client client(server.port());
    client.send(request);
    ::usleep(1000);
    client.reset();
  }
  EXPECT_EQ(body_of(other.receive()), large);
}

TEST_F(HostileView, TwoAtOnce_HaveTheirBytes) {
  const std::string large = large_capture();
  const Server server(folder, {folder.file("large.csv", large)});
  const Client first(server.port());
  const Client second(server.port());
  first.send(filled_in(server, with("Connection: close")));
  second.send(filled_in(server, with("Connection: close\r\nRange: bytes=7-")));
  EXPECT_EQ(body_of(second.receive()), large.substr(7));
  EXPECT_EQ(body_of(first.receive()), large);
}

// An answer that has begun is as long as announced, or ends with the connection.
TEST_F(HostileView, FileThatChangesInAnAnswer_GivesNoOtherBytes) {
  const std::string large = large_capture();
  const std::string path = folder.path("large.csv");
  const auto received = [&](const auto& change) {
    folder.file("large.csv", large);
    const Server server(folder, {path, "--follow"});
    const Client client(server.port());
    client.send(filled_in(server, with("Connection: close")));
    // The answer has begun, and waits for the client.
    EXPECT_EQ(body_of(server.get("capture", "Range: bytes=0-3\r\n")), "time");
    change();
    const std::string answer = client.receive();
    EXPECT_THAT(answer, HasSubstr(fmt::format("Content-Length: {}\r\n", large.size())));
    EXPECT_THAT(server.get("size"), StartsWith("HTTP/1.1 "));
    return body_of(answer);
  };
  EXPECT_EQ(received([&] { std::ofstream(path, std::ios::app) << "300,0,1\n"; }), large);
  EXPECT_EQ(received([&] { std::filesystem::remove(path); }), large);
  EXPECT_EQ(received([&] {
              std::filesystem::rename(folder.file("b.csv", std::string(64U << 20U, 'x')), path);
            }),
            large);
  const std::string part = received([&] { std::filesystem::resize_file(path, 100); });
  EXPECT_LT(part.size(), large.size());
  EXPECT_EQ(part, large.substr(0, part.size()));
}

TEST_F(HostileView, SignalInAnAnswer_EndsItWithSuccess) {
  const std::string large = large_capture();
  const std::string path = folder.file("large.csv", large);
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) {
    Server server(folder, {path});
    server.signal(SIGPIPE);
    server.signal(SIGSTOP);
    server.signal(SIGCONT);
    const Client client(server.port());
    client.send(filled_in(server, capture_too));
    EXPECT_EQ(body_of(server.get("size")), fmt::format("{}", large.size()));
    EXPECT_EQ(server.end(number), 0);
    EXPECT_LT(body_of(client.receive()).size(), large.size());
  }
}

}  // namespace biss::verbs::view_test
