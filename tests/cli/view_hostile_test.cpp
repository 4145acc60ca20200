// Hostile requests to the server of `biss view`, and clients and files that change in an answer.
#include "tests/cli/view_server.hpp"

namespace biss::verbs::view_test {

using HostileView = InFolder;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// HOST stands for the name of the server with its PORT, PATH for /TOKEN/, PART for a part of TOKEN.
struct Hostile {
  std::string situation;
  std::string request;
  // The status of each answer, and the length of 200 and 206. Then the server ends the connection.
  std::string answers;
};

std::string with_target(const std::string& target) {
  return "GET " + target + " HTTP/1.1\r\nHost: HOST\r\n\r\n";
}
std::string with_method(const std::string& method) {
  return method + " PATHcapture HTTP/1.1\r\nHost: HOST\r\n\r\n";
}
std::string with_headers(const std::string& headers, const std::string& body = {}) {
  return "GET PATHcapture HTTP/1.1\r\n" + headers + "\r\n" + body;
}
std::string with_host(const std::string& host) { return with_headers("Host: " + host + "\r\n"); }
std::string with(const std::string& header, const std::string& body = {}) {
  return with_headers("Host: HOST\r\n" + header + "\r\n", body);
}
std::string with_header(const std::string& header) { return with(header); }
std::string alone(const std::string& request) { return request; }
const std::string capture_too = with_headers("Host: HOST\r\n");
const std::string size_too = "GET PATHsize HTTP/1.1\r\nHost: HOST\r\n\r\n";
std::string with_size_too(const std::string& header) { return with(header, size_too); }

using Tables = std::vector<std::vector<Hostile>>;

// Requests with the same answer, made of these parts.
std::vector<Hostile> each(const std::string& answers, std::string (*request)(const std::string&),
                          const std::vector<std::string>& parts) {
  std::vector<Hostile> table;
  for (const std::string& part : parts) table.push_back({part, request(part), answers});
  return table;
}

Tables first_lines() {
  return {
      each("403", with_target,
           {"/", "/capture", "/00000000000000000000000000000000/capture", "/NEAR/", "/NEAR/capture",
            "/PART/", "/.PATHcapture", "/PATH", "/TOKEN0/capture", "/?TOKEN", "/x/TOKEN/capture",
            "/TOKEN;/capture", "/TOKEN#/capture", "/TOKEN%00/capture", "/x/../TOKEN/capture",
            "http://HOSTPATHcapture", "TOKEN/", "*"}),
      each("404", with_target,
           {"/TOKEN",
            "PATHTOKEN/capture",
            "PATHsecret",
            "PATH../secret",
            "PATH..",
            "PATH%2e%2e/secret",
            "PATH%252e%252e/secret",
            "PATH..%2fsecret",
            "PATH..\\secret",
            "PATH..%5csecret",
            "PATH\xc0\xae\xc0\xae/secret",
            "PATH/etc/passwd",
            "PATHbiss.html",
            "PATHcapture/",
            "PATHcapture/../capture",
            "PATH./capture",
            "PATH%63apture",
            "PATHCapture",
            "PATHcapture?x",
            "PATHcapture#x",
            "PATHcapture%00",
            "PATH" + std::string(8000, 'a')}),
      each("400", with_target,
           {std::string("PATHcapture\0", 12), "PATHcapture\x7f", "PATH capture", "PATH\tcapture",
            "", "/" + std::string(100'000, 'a')}),
      each("405", with_method,
           {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "BREW", "get", std::string(8000, 'A')}),
      each("400", with_method, {"", std::string(17'000, 'A')}),
      each("400", alone,
           {"\r\n\r\n", "nonsense\r\n\r\n", std::string(100, '\0'), "GET\r\n\r\n",
            std::string("\x16\x03\x01\x02\x00\x01\x00\x01", 8) + "\r\n\r\n",
            "GET PATH" + std::string(17'000, 'a'), std::string(17'000, 'A')}),
      {{"nothing", "", ""},
       {"token in headers", "GET /capture HTTP/1.1\r\nHost: HOST\r\nCookie: TOKEN\r\n\r\n", "403"},
       {"authority form", "CONNECT HOST HTTP/1.1\r\nHost: HOST\r\n\r\n", "403"},
       {"asterisk form", "OPTIONS * HTTP/1.1\r\nHost: HOST\r\n\r\n", "403"},
       {"HTTP/1.0", "GET PATHcapture HTTP/1.0\r\nHost: HOST\r\n\r\n", "200/38"},
       {"HTTP/1.0 without Host", "GET PATHcapture HTTP/1.0\r\n\r\n", "403"},
       {"HTTP/0.9", "GET PATHcapture\r\n", "400"},
       {"HTTP/2.0", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", "400"},
       {"HTTP/1.2", "GET PATHcapture HTTP/1.2\r\nHost: HOST\r\n\r\n", "400"},
       {"HTTP/9.9", "GET / HTTP/9.9\r\n\r\n", "400"},
       {"http", "GET PATHcapture http/1.1\r\nHost: HOST\r\n\r\n", "400"},
       {"blank after the version", "GET PATHcapture HTTP/1.1 \r\nHost: HOST\r\n\r\n", "400"}},
  };
}

Tables hosts() {
  return {
      each("200/38", with_host, {"localhost:PORT", "\r\n\tHOST \t"}),
      each("403", with_host,
           {"",
            "evil.example",
            "evil.example:PORT",
            "127.0.0.1",
            "127.0.0.1:1",
            "HOST0",
            "127.0.0.1:0PORT",
            "[::1]:PORT",
            "[::ffff:127.0.0.1]:PORT",
            "0.0.0.0:PORT",
            "127.1:PORT",
            "2130706433:PORT",
            "127.0.0.1.evil:PORT",
            "evil.localhost:PORT",
            "localhost.:PORT",
            "evil@HOST",
            "HOST, evil",
            "HOST\r\nHost: HOST",
            "HOST\r\nhost: evil",
            "evil\r\nX-Forwarded-Host: HOST"}),
      each("400", with_host, {std::string("HOST\0", 5)}),
      {{"none", with_headers(""), "403"},
       {"blank before the colon", with_headers("Host : HOST\r\n"), "400"},
       {"no colon", with_headers("Host\r\n"), "400"}},
  };
}

Tables headers() {
  std::string thousands;
  for (int i = 0; i < 3000; ++i) thousands += "A: 1\r\n";
  return {
      each("400", with_header,
           {"X: a\nY: b", "X: a\rY: b", "Range", ": x", "X Y: a", "X\x01: a",
            std::string("X: \0", 4), "X: " + std::string(17'000, 'x'),
            "X: " + std::string(100'000, 'x'), std::string(17'000, 'X') + ": a", thousands + "B: 1",
            "Connection: ,;,", "Content-Length: -1"}),
      each(
          "200/38", with_header,
          {"X: \xe4\xff", "X: a\r\n b", "X: " + std::string(15'000, 'x'), thousands.substr(0, 5998),
           "Expect: 100-continue", "Connection: Upgrade\r\nUpgrade: h2c"}),
      // A text that is not a range means the whole file.
      each("200/38", with_header,
           {"Range:", "Range: bytes=", "Range: bytes=+1-2", "Range: bytes= 1-2",
            "Range: bytes=0x1-2", "Range: bytes=1-2-3", "Range: lines=1-2", "Range: bytes=0-5,3-9",
            "Range: bytes=0-1,3-4", "Range: bytes=7-5", "Range: bytes=a-b", "Range: bytes=--1",
            "Range: bytes=99999999999999999999-", "Range: bytes=-",
            "Range: bytes=0-0" + std::string(900, ','), "Range: bytes=0-0\r\nRange: bytes=1-1",
            "Range: bytes=0-0\r\nIf-Range: \"1\""}),
      {{"LF alone", "GET PATHcapture HTTP/1.1\nHost: HOST\n\n", "400"},
       {"CR alone", "GET PATHcapture HTTP/1.1\rHost: HOST\r\r", "400"},
       {"no end of the headers", "GET PATHcapture HTTP/1.1\r\nHost: HOST\r\n", ""},
       {"line before the request", "\r\n" + capture_too, "400"},
       {"folded first", with_headers(" X: a\r\nHost: HOST\r\n"), "400"}},
  };
}

// Bytes after the header are a body, which the server ignores, or the next request.
Tables bodies() {
  std::string hundreds;
  std::string answers;
  for (int i = 0; i < 300; ++i, answers += "206/1 ") hundreds += with("Range: bytes=0-0");
  return {
      each("200/38 200/2", with_size_too, {"Content-Length: 0", "Content-Length: 0, 0"}),
      each("200/38", with_size_too, {"Content-Length: 90", "Content-Length: 900"}),
      each("400", with_size_too,
           {"Content-Length: 9999999999", "Content-Length: 0x0", "Content-Length: +0",
            "Content-Length: 18446744073709551616", "Content-Length: 0\r\nContent-Length: 90",
            "Content-Length: 0, 90", "Content-Length: 0\r\nTransfer-Encoding: chunked",
            "Transfer-Encoding: gzip", "Transfer-Encoding: chunked, gzip",
            "Transfer-Encoding: xchunked", "Transfer-Encoding:\vchunked"}),
      {{"pipelined", with("Range: bytes=3-4") + size_too + capture_too, "206/2 200/2 200/38"},
       {"body of POST", "POST" + with("Content-Length: 90", size_too).substr(3), "405"},
       {"chunks", with("Transfer-Encoding: chunked", "0\r\n\r\n" + size_too), "200/38"},
       {"wrong chunks", with("Transfer-Encoding: chunked", "-1\r\n" + size_too), "200/38"},
       {"chunks and length",
        with("Transfer-Encoding: chunked\r\nContent-Length: 0", "0\r\n\r\n" + size_too), "400"},
       {"request after the last one", with("Connection: close") + size_too, "200/38"},
       {"request after a refused one", with_target("/") + size_too, "403"},
       {"noise after a request", capture_too + "\x16\x03\x01 " + size_too, "200/38 400"},
       {"HEAD, pipelined", "HEAD" + capture_too.substr(3) + size_too, "200/38 200/2"},
       {"hundreds, pipelined", hundreds + "x\r\n", answers + "400"}},
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
  std::string near = token;
  near[0] = near[0] == '0' ? '1' : '0';
  for (const auto& [name, value] :
       {std::pair{std::string("PATH"), server.path()}, std::pair{std::string("TOKEN"), token},
        std::pair{std::string("PART"), token.substr(0, 19)}, std::pair{std::string("NEAR"), near},
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
  for (const Tables& tables : {first_lines(), hosts(), headers(), bodies()}) {
    for (const auto& table : tables) {
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
        if (hostile.answers == "200/38") {
          EXPECT_EQ(body_of(received), capture_text) << hostile.situation;
        }
        if (hostile.answers == "405") {
          EXPECT_THAT(received, HasSubstr("Allow: GET, HEAD\r\n")) << hostile.situation;
        }
        EXPECT_EQ(body_of(server.get("capture")), capture_text) << hostile.situation;
      }
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
