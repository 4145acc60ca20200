// A part of the emscripten runtime that reads beyond 4 GiB: its own one takes offsets of 32 bits.
mergeInto(LibraryManager.library, {
  fd_pread__sig: 'iiiiji',
  fd_pread: function (fd, iov, iovcnt, offset, pnum) {
    var stream = SYSCALLS.getStreamFromFD(fd);
    var num = SYSCALLS.doReadv(stream, iov, iovcnt, Number(offset));
    {{{ makeSetValue('pnum', 0, 'num', 'i32') }}};
    return 0;
  },
});
