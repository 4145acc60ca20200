// The function of LZ4 that the reader of FST uses.
#pragma once

/// Decompresses a block of the LZ4 block format. Returns the bytes made, negative where `in` is
/// damaged or needs more room.
int LZ4_decompress_safe(const char* in, char* out, int in_bytes, int out_bytes);
