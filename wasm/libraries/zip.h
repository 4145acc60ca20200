// The functions of libzip that the readers use: archives of stored and deflated members, read.
#pragma once

#include <cstdint>
#include <cstdio>

using zip_int64_t = std::int64_t;
using zip_uint64_t = std::uint64_t;
using zip_uint32_t = std::uint32_t;
using zip_uint16_t = std::uint16_t;
using zip_flags_t = std::uint32_t;

struct zip;
struct zip_file;
struct zip_source;
struct zip_error;
using zip_t = zip;
using zip_file_t = zip_file;
using zip_source_t = zip_source;
using zip_error_t = zip_error;

constexpr int ZIP_RDONLY = 16;
constexpr zip_flags_t ZIP_FL_COMPRESSED = 4;
constexpr zip_flags_t ZIP_FL_ENC_RAW = 64;
constexpr zip_uint16_t ZIP_CM_STORE = 0;
constexpr zip_uint16_t ZIP_CM_DEFLATE = 8;
constexpr zip_uint16_t ZIP_EM_NONE = 0;
constexpr zip_uint16_t ZIP_EM_TRAD_PKWARE = 1;
constexpr zip_uint64_t ZIP_STAT_INDEX = 0x02;
constexpr zip_uint64_t ZIP_STAT_SIZE = 0x04;
constexpr zip_uint64_t ZIP_STAT_COMP_SIZE = 0x08;
constexpr zip_uint64_t ZIP_STAT_CRC = 0x20;
constexpr zip_uint64_t ZIP_STAT_COMP_METHOD = 0x40;
constexpr zip_uint64_t ZIP_STAT_ENCRYPTION_METHOD = 0x80;

struct zip_stat_t {
  zip_uint64_t valid;
  zip_uint64_t index;
  zip_uint64_t size;
  zip_uint64_t comp_size;
  zip_uint32_t crc;
  zip_uint16_t comp_method;
  zip_uint16_t encryption_method;
};

/// The source closes the stream. \pre from the beginning to the end
zip_source_t* zip_source_filep_create(std::FILE* file, zip_uint64_t start, zip_int64_t length,
                                      zip_error_t* error);
/// The bytes must outlive the source.
zip_source_t* zip_source_buffer_create(const void* bytes, zip_uint64_t count, int free_later,
                                       zip_error_t* error);
void zip_source_free(zip_source_t* source);
int zip_source_stat(zip_source_t* source, zip_stat_t* about);

/// Null where the directory is missing or wrong. On success the archive frees the source.
zip_t* zip_open_from_source(zip_source_t* source, int flags, zip_error_t* error);
void zip_discard(zip_t* archive);
zip_int64_t zip_get_num_entries(zip_t* archive, zip_flags_t flags);
int zip_stat_index(zip_t* archive, zip_uint64_t index, zip_flags_t flags, zip_stat_t* about);
zip_int64_t zip_name_locate(zip_t* archive, const char* name, zip_flags_t flags);
const char* zip_get_name(zip_t* archive, zip_uint64_t index, zip_flags_t flags);

/// \param flags ZIP_FL_COMPRESSED gives the bytes as they are in the archive
zip_file_t* zip_fopen_index(zip_t* archive, zip_uint64_t index, zip_flags_t flags);
/// The bytes read, 0 at the end; negative where the member is damaged, its checksum included.
zip_int64_t zip_fread(zip_file_t* file, void* into, zip_uint64_t count);
int zip_fclose(zip_file_t* file);
