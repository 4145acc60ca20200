// The server of `biss view`, asked by sockets of this test.
#include "tests/cli/view_server.hpp"

namespace biss::verbs::view_test {

using ViewVerb = InFolder;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;
using testing::StartsWith;

TEST_F(ViewVerb, PageAndCapture_AreGivenAtTheAddressPrinted) {
  const Server server(folder, {folder.file("a&b.csv", capture_text), "-f", "resolute-26", "--ma",
                               "MA", "--invert-slo", "--ack-max", "16us", "--unwrap"});
  EXPECT_THAT(server.address(), MatchesRegex("http://127\\.0\\.0\\.1:[0-9]+/[0-9a-f]{32}/"));
  const std::string html = server.get("");
  EXPECT_THAT(html, StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(html, HasSubstr(R"(id="biss-capture" data-name="a&amp;b.csv" data-address="capture")"
                              R"( data-size="38")"));
  EXPECT_THAT(html, HasSubstr("format=resolute-26&amp;ma=MA&amp;invert=slo&amp;"
                              "further=--ack-max%2016us%20--unwrap\""));
  const std::string capture = server.get("capture");
  EXPECT_THAT(capture, StartsWith("HTTP/1.1 200 "));
  EXPECT_EQ(body_of(capture), capture_text);
  EXPECT_EQ(body_of(server.get("size")), "38");
  const std::string head =
      server.ask("HEAD " + server.path() + "capture", "Host: " + server.host() + "\r\n");
  EXPECT_THAT(head, HasSubstr("Content-Length: 38\r\n"));
  EXPECT_EQ(body_of(head), "");
}

TEST_F(ViewVerb, EveryAnswer_HasTheHeadersThatProtectIt) {
  const Server server(folder, {folder.file("a.csv", capture_text)});
  for (const char* const below : {"", "capture", "nothing"}) {
    const std::string answer = server.get(below);
    for (const char* const header :
         {"Cache-Control: no-store", "X-Content-Type-Options: nosniff", "X-Frame-Options: DENY",
          "Content-Security-Policy: frame-ancestors 'none'", "Referrer-Policy: no-referrer",
          "Cross-Origin-Resource-Policy: same-origin"}) {
      EXPECT_THAT(answer, HasSubstr(header)) << below;
    }
    EXPECT_THAT(answer, Not(HasSubstr("Access-Control")));
  }
}

TEST_F(ViewVerb, Range_IsGivenToTheByte) {
  const Server server(folder, {folder.file("a.csv", capture_text)});
  const auto expect = [&](const std::string& range, std::size_t from, std::size_t count) {
    const std::string answer = server.get("capture", "Range: bytes=" + range + "\r\n");
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 206 ")) << range;
    EXPECT_THAT(answer, HasSubstr(fmt::format("Content-Range: bytes {}-{}/38\r\n", from,
                                              from + count - 1)));
    EXPECT_EQ(body_of(answer), capture_text.substr(from, count)) << range;
  };
  expect("0-0", 0, 1);
  expect("5-13", 5, 9);
  expect("37-37", 37, 1);
  expect("30-", 30, 8);
  expect("30-999", 30, 8);
  expect("30-18446744073709551615", 30, 8);
  expect("-3", 35, 3);
  expect("-999", 0, 38);
  for (const char* const beyond : {"38-", "38-40", "18446744073709551615-", "-0"}) {
    const std::string answer = server.get("capture", fmt::format("Range: bytes={}\r\n", beyond));
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 416 ")) << beyond;
    EXPECT_THAT(answer, HasSubstr("Content-Range: bytes */38\r\n"));
  }
}

TEST_F(ViewVerb, SlowClients_DoNotBlockAnother) {
  const Server server(folder, {folder.file("a.csv", capture_text)});
  std::vector<std::unique_ptr<Client>> slow;
  // More than the server keeps at a time.
  for (int i = 0; i < 300; ++i) {
    slow.push_back(std::make_unique<Client>(server.port()));
    ASSERT_TRUE(slow.back()->connected());
    slow.back()->send(i % 2 == 0 ? "GET /" : "");
  }
  EXPECT_EQ(body_of(server.get("capture")), capture_text);
}

TEST_F(ViewVerb, ClientThatDoesNotRead_DoesNotBlockAnother) {
  const std::string large = folder.file("large.csv", capture_text + std::string(64U << 20U, '\n'));
  const Server server(folder, {large});
  const Client slow(server.port());
  slow.send("GET " + server.path() + "capture HTTP/1.1\r\nHost: " + server.host() + "\r\n\r\n");
  EXPECT_EQ(body_of(server.get("capture", "Range: bytes=0-3\r\n")), "time");
}

TEST_F(ViewVerb, GrowingFile_IsGivenToItsLastWholeLine) {
  const std::string path = folder.file("a.csv", "");
  const Server server(folder, {path, "--follow"});
  EXPECT_EQ(body_of(server.get("size")), "0");
  std::ofstream file(path, std::ios::binary);
  const auto write = [&](const char* text) { file << text << std::flush; };
  write("time_ns,MA,S");
  EXPECT_EQ(body_of(server.get("size")), "0");
  write("LO\n0,1,1\n10");
  EXPECT_EQ(body_of(server.get("size")), "21");
  EXPECT_EQ(body_of(server.get("capture")), "time_ns,MA,SLO\n0,1,1\n");
  EXPECT_THAT(server.get("capture", "Range: bytes=21-\r\n"), StartsWith("HTTP/1.1 416 "));
  write("0,0,1\n");
  EXPECT_EQ(body_of(server.get("capture", "Range: bytes=21-\r\n")), "100,0,1\n");
}

TEST_F(ViewVerb, GrowingRawSamples_AreGivenToTheLastWholeOne) {
  const std::string path = folder.file("a.bin", "abcdefg");
  const Server server(folder, {path, "--follow", "--raw-rate", "10MHz", "--raw-bytes", "4"});
  EXPECT_EQ(body_of(server.get("size")), "4");
  std::ofstream(path, std::ios::app) << "h";
  EXPECT_EQ(body_of(server.get("capture")), "abcdefgh");
}

TEST_F(ViewVerb, WithoutFollow_TheFileIsWhatItWas) {
  const std::string path = folder.file("a.csv", capture_text);
  const Server server(folder, {path});
  std::ofstream(path, std::ios::app) << "300,0,1\n";
  EXPECT_EQ(body_of(server.get("capture")), capture_text);
}

TEST_F(ViewVerb, FileThatChangesOtherwise_IsNamed) {
  const std::string path = folder.path("a.csv");
  const auto problem = [&](const auto& change) {
    folder.file("a.csv", capture_text);
    const Server server(folder, {path, "--follow"});
    change();
    const std::string answer = server.get("capture");
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 410 "));
    // It stays so.
    folder.file("a.csv", capture_text);
    EXPECT_EQ(body_of(server.get("size")), body_of(answer));
    return body_of(answer);
  };
  EXPECT_THAT(problem([&] { folder.file("a.csv", "time_ns"); }),
              HasSubstr("a.csv: has shrunk from 38 to 7 bytes while it was read"));
  EXPECT_THAT(problem([&] { std::filesystem::rename(folder.file("b.csv", capture_text), path); }),
              HasSubstr("a.csv: was replaced by another file while it was read"));
  EXPECT_THAT(problem([&] { folder.file("a.csv", capture_text.substr(1) + "300,0,1\n"); }),
              HasSubstr("a.csv: was rewritten while it was read"));
  EXPECT_THAT(problem([&] { std::filesystem::remove(path); }),
              HasSubstr("a.csv: No such file or directory; it was there"));
}

TEST_F(ViewVerb, ChangeInPlaceAtAnyByte_IsNamed) {
  std::string rows = "time_ns,MA,SLO\n";
  for (int i = 0; rows.size() < 300'000; ++i) rows += fmt::format("{},{},1\n", i * 100, i % 2);
  for (const char* option : {"--follow", "--no-compensation"}) {
    for (const std::size_t at : {5'000UL, 150'000UL, 290'000UL}) {
      SCOPED_TRACE(fmt::format("{} {}", option, at));
      const std::string path = folder.file("a.csv", rows);
      const Server server(folder, {path, option});
      EXPECT_EQ(body_of(server.get("capture")).size(), rows.size());
      std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
      file.seekp(static_cast<std::streamoff>(rows.find(",1,1", at) + 1));
      file << '0' << std::flush;
      EXPECT_THAT(body_of(server.get("size")),
                  HasSubstr("a.csv: was rewritten while it was read; start biss view again"));
    }
  }
}

TEST_F(ViewVerb, ChangeInPlaceOfAFileThatGrows_IsNamed) {
  const std::string path = folder.file("a.csv", capture_text + std::string(100'000, '\n'));
  const Server server(folder, {path, "--follow"});
  std::ofstream(path, std::ios::app) << "300,0,1\n";
  EXPECT_EQ(body_of(server.get("size")), fmt::format("{}", capture_text.size() + 100'008));
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(50'000);
  file << "7";
  file.seekp(0, std::ios::end);
  file << "400,1,1\n" << std::flush;
  EXPECT_THAT(body_of(server.get("size")), HasSubstr("was rewritten while it was read"));
}

TEST_F(ViewVerb, FileTouchedOnly_IsServedOn) {
  const std::string path = folder.file("a.csv", capture_text);
  for (const char* option : {"--follow", "--no-compensation"}) {
    const Server server(folder, {path, option});
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now());
    EXPECT_EQ(body_of(server.get("capture")), capture_text);
  }
}

TEST_F(ViewVerb, FileWithoutALineFeed_IsNamed) {
  const std::string one_line =
      "$timescale 1ns $end $var wire 1 ! MA $end $enddefinitions $end #0 1!";
  EXPECT_THAT(run("view {} --follow --no-open", folder.file("a.vcd", one_line)),
              fails(3,
                    "a.vcd: cannot be followed while it grows: it has no line "
                    "feed yet; leave out --follow"));
  const std::string long_line = capture_text + std::string(2U << 20U, '1');
  EXPECT_THAT(run("view {} --follow --no-open", folder.file("a.csv", long_line)),
              fails(3, "its last line has more than 1 MiB; leave out --follow"));
  // It may be the first line, half written. One that does not grow from look to look is none.
  const std::string path = folder.file("b.vcd", "");
  const Server server(folder, {path, "--follow"});
  std::ofstream file(path, std::ios::binary);
  file << one_line.substr(0, 20) << std::flush;
  EXPECT_EQ(body_of(server.get("size")), "0");
  file << one_line.substr(20) << std::flush;
  EXPECT_EQ(body_of(server.get("size")), "0");
  EXPECT_THAT(body_of(server.get("size")), HasSubstr("b.vcd: cannot be followed while it grows: "
                                                     "it has no line feed yet"));
}

TEST_F(ViewVerb, RowsThatEndInCrAlone_CannotBeFollowed) {
  const std::string path = folder.file("a.csv", std::string("time_ns,MA,SLO\n0,1,1\r5,0,1\r"));
  EXPECT_THAT(run("view {} --follow --no-open", path),
              fails(3,
                    "a.csv: cannot be followed while it grows: it has lines that "
                    "end in CR alone; leave out --follow"));
  // CR LF, of which LF is not there yet.
  const Server server(folder,
                      {folder.file("b.csv", std::string("time_ns,MA\r\n0,1\r")), "--follow"});
  EXPECT_EQ(body_of(server.get("size")), "12");
}

TEST_F(ViewVerb, FileThatCannotBeFollowed_IsNamed) {
  const auto expect = [&](const std::string& name, const std::string& content, const char* why) {
    EXPECT_THAT(run("view {} --follow --no-open", folder.file(name, content)),
                fails(3, name + ": cannot be followed while it grows: " + why));
  };
  expect("a.sr", "PK\3\4", "the directory of an archive");
  expect("a.vcd.gz", "\x1f\x8b\b", "a compressed file ends with its checksum");
  expect("a.bin", std::string("\1\0\1", 3),
         "it is not text (VCD, CSV), and raw samples need --raw");
}

TEST_F(ViewVerb, Signal_EndsItWithSuccess) {
  const std::string path = folder.file("a.csv", capture_text);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    Server server(folder, {path});
    const Client open(server.port());
    EXPECT_EQ(body_of(server.get("size")), "38");
    EXPECT_EQ(server.end(signal), 0);
  }
}

TEST_F(ViewVerb, Browser_GetsAnAddressThatLeadsToThePageOnce) {
  const std::string opened = folder.path("opened");
  // As a whole line, so that it is read when it is complete.
  const std::string script = folder.file("xdg-open", "#!/bin/sh\necho \"$1\" >" + opened + "\n");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (folder.path("") + ":" + path).c_str(), 1);
  const Server server(folder, {folder.file("a.csv", capture_text)}, Opening::browser);
  ::setenv("PATH", path.c_str(), 1);
  std::string address;
  for (int i = 0; i < 2000 && !address.ends_with('\n'); ++i, ::usleep(10'000)) {
    address = content_of(opened);
  }
  ASSERT_THAT(address, StartsWith("http://" + server.host() + "/"));
  EXPECT_THAT(address, Not(HasSubstr(server.path())));
  const std::string target = address.substr(address.rfind('/'), 33);
  const auto open = [&] { return server.ask("GET " + target, "Host: " + server.host() + "\r\n"); };
  const std::string first = open();
  EXPECT_THAT(first, StartsWith("HTTP/1.1 303 "));
  EXPECT_THAT(first, HasSubstr("Location: " + server.path() + "\r\n"));
  EXPECT_THAT(open(), StartsWith("HTTP/1.1 403 "));
}

TEST_F(ViewVerb, Port_IsTheOneGivenOrIsRefused) {
  const std::string path = folder.file("a.csv", capture_text);
  std::string port;
  {
    const Server first(folder, {path});
    port = std::to_string(first.port());
    EXPECT_THAT(run("view {} --no-open --port {} --page {}", path, port, folder.path("biss.html")),
                fails(3, "cannot listen at 127.0.0.1:" + port + ": Address already"));
  }
  const Server second(folder, {path, "--port", port});
  EXPECT_EQ(std::to_string(second.port()), port);
}

TEST_F(ViewVerb, WrongUsage_IsOneLineThatSaysWhy) {
  const std::string path = folder.file("a.csv", capture_text);
  const auto expect = [&](const Words& words, int status, const std::string& why) {
    EXPECT_THAT(run(Words("view") + words), refuses(status, why));
  };
  expect({}, 2, "name a capture, or a line by --port spi:DEVICE");
  expect({path, "--port", "spi:/no/device"}, 2, "name a capture, or a line");
  expect({"--port", "spi:/no/device"}, 2, "--port: give the format of the line by -f");
  expect({"--port", "spi:/no/device", "-f", "resolute-26"}, 3, "not found; is SPI switched on");
  expect({path, "--port", "usb:1"}, 2, "--port");
  expect({path, path}, 2, "unexpected argument");
  expect({"-"}, 2, "-: the page asks for parts of the capture; name a file");
  expect({path, "-f", "nothing"}, 2, "nothing");
  expect({path, "--port", "65536"}, 2, "--port");
  expect({path, "--max-step", "3"}, 2, "--max-step: only with --unwrap or --velocity");
  expect({"/nowhere/a.csv"}, 3, "/nowhere/a.csv: No such file or directory");
  expect({folder.path("")}, 3, "is not a regular file");
  expect({path, "--page", path}, 3, "is not the page of biss");
}

TEST_F(ViewVerb, Help_AsksForOneFileOrAPort) {
  const Outcome help = run("view --help");
  EXPECT_THAT(help.out, HasSubstr("Usage: biss view [OPTION]... [FILE]\n"));
  EXPECT_THAT(help.out, HasSubstr("spi:/dev/spidev0.0"));
  EXPECT_THAT(help.out, Not(HasSubstr("--each")));
}

}  // namespace biss::verbs::view_test
