/* A program that uses spidev as its documentation says, and knows nothing of an emulation.
 *
 *   spidev_client read DEVICE COUNT BYTES SPEED   a line of hexadecimal digits for each message
 *   spidev_client twice DEVICE COUNT BYTES SPEED  two processes at once; their errors
 *   spidev_client mistakes DEVICE                 the results of calls that cannot work
 *   spidev_client until-error DEVICE              messages until one fails; its error
 */
#include <errno.h>
#include <fcntl.h>
#include <linux/spi/spidev.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

static int open_device(const char* path) {
  const int device = open(path, O_RDWR);
  uint8_t mode = SPI_MODE_3;
  if (device < 0 || ioctl(device, SPI_IOC_WR_MODE, &mode) != 0) {
    perror(path);
    exit(1);
  }
  return device;
}

static int exchange(int device, uint8_t* in, const uint8_t* out, uint32_t bytes, uint32_t speed) {
  struct spi_ioc_transfer transfer;
  memset(&transfer, 0, sizeof transfer);
  transfer.tx_buf = (uintptr_t)out;
  transfer.rx_buf = (uintptr_t)in;
  transfer.len = bytes;
  transfer.speed_hz = speed;
  return ioctl(device, SPI_IOC_MESSAGE(1), &transfer);
}

static int read_frames(int device, int count, uint32_t bytes, uint32_t speed, int print) {
  static uint8_t out[4096];
  static uint8_t in[4096];
  memset(out, 0xFF, sizeof out);
  for (int i = 0; i < count; ++i) {
    if (exchange(device, in, out, bytes, speed) != (int)bytes) {
      perror("message");
      return 1;
    }
    for (uint32_t k = 0; print && k < bytes; ++k) printf("%02X", in[k]);
    if (print) putchar('\n');
  }
  return 0;
}

static void show(const char* what, long result) {
  printf("%s: %ld %s\n", what, result, result < 0 ? strerror(errno) : "");
}

static int make_mistakes(const char* path) {
  const int device = open_device(path);
  uint8_t buffer[16] = {0};
  uint8_t* const gone =
      mmap(NULL, 8192, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  munmap(gone + 4096, 4096);
  show("wrong out", exchange(device, buffer, (uint8_t*)8, 8, 0));
  show("wrong in", exchange(device, (uint8_t*)8, buffer, 8, 0));
  show("end of memory", exchange(device, gone + 4090, buffer, 8, 0));
  show("read-only", exchange(device, (uint8_t*)(uintptr_t) "constant text", buffer, 8, 0));
  show("the device itself",
       exchange(device, buffer, mmap(NULL, 4096, PROT_READ, MAP_PRIVATE, device, 0), 8, 0));
  show("too long", exchange(device, NULL, NULL, 0xFFFFFFFF, 0));
  show("null argument", ioctl(device, SPI_IOC_MESSAGE(1), NULL));
  show("another request", ioctl(device, _IO('k', 77)));
  static uint8_t many[16352];
  show("long read", read(device, many, 4097));
  show("long write", write(device, many, 4097));
  show("many", ioctl(device, _IOC(_IOC_WRITE, SPI_IOC_MAGIC, 0, sizeof many), many));
  show("good", exchange(device, buffer, buffer, 16, 0));
  return 0;
}

int main(int argc, char** argv) {
  if (argc == 6 && strcmp(argv[1], "read") == 0) {
    return read_frames(open_device(argv[2]), atoi(argv[3]), (uint32_t)atoi(argv[4]),
                       (uint32_t)atoi(argv[5]), 1);
  }
  if (argc == 6 && strcmp(argv[1], "twice") == 0) {
    const pid_t child = fork();
    const int failed = read_frames(open_device(argv[2]), atoi(argv[3]), (uint32_t)atoi(argv[4]),
                                   (uint32_t)atoi(argv[5]), 0);
    int status = 0;
    if (child == 0) return failed;
    waitpid(child, &status, 0);
    return failed != 0 || status != 0;
  }
  if (argc == 3 && strcmp(argv[1], "mistakes") == 0) return make_mistakes(argv[2]);
  if (argc == 3 && strcmp(argv[1], "until-error") == 0) {
    const int device = open_device(argv[2]);
    while (read_frames(device, 1, 16, 0, 0) == 0) puts("read");
    return 4;
  }
  fputs("spidev_client: wrong usage\n", stderr);
  return 2;
}
