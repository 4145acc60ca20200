# Libraries for WebAssembly. Debian has no libraries for it: these are headers alone, or are compiled
# from Debian's source packages.
if(NOT CMAKE_CXX_COMPILER_VERSION)
  message(FATAL_ERROR "BissWasm needs the toolchain file of emscripten")
endif()
enable_language(C)
set(BISS_WASM_SOURCES "/usr/src/biss-wasm" CACHE PATH "The sources from scripts/install-packages wasm")

# /usr/include itself holds the headers of this machine's C library.
set(wasm_headers "${PROJECT_BINARY_DIR}/headers")
file(MAKE_DIRECTORY "${wasm_headers}")
foreach(path IN ITEMS /usr/include/boost /usr/include/fmt /usr/include/hwy /usr/include/nlohmann
                      /usr/include/tl libdeflate/libdeflate.h libzip/lib/zip.h libzstd/lib/zstd.h
                      libzstd/lib/zstd_errors.h lz4/lib/lz4.h zlib/zconf.h zlib/zlib.h)
  cmake_path(ABSOLUTE_PATH path BASE_DIRECTORY "${BISS_WASM_SOURCES}")
  if(NOT EXISTS "${path}")
    message(FATAL_ERROR "${path} is missing; scripts/install-packages build wasm")
  endif()
  cmake_path(GET path FILENAME name)
  file(CREATE_LINK "${path}" "${wasm_headers}/${name}" SYMBOLIC)
endforeach()

add_library(biss_wasm_headers INTERFACE)
target_include_directories(biss_wasm_headers SYSTEM INTERFACE "${wasm_headers}")
target_compile_definitions(biss_wasm_headers INTERFACE FMT_HEADER_ONLY)
foreach(name IN ITEMS fmt::fmt nlohmann_json::nlohmann_json hwy::hwy Threads::Threads)
  add_library(${name} INTERFACE IMPORTED GLOBAL)
  target_link_libraries(${name} INTERFACE biss_wasm_headers)
endforeach()

# libzip: its list of errors is for texts, which the readers do not use.
function(wasm_configure_libzip)
  foreach(name IN ITEMS FILENO FSEEKO FTELLO LOCALTIME_R NULLABLE STRCASECMP STRDUP STDBOOL_H
                        STRINGS_H UNISTD_H)
    set(HAVE_${name} 1)
  endforeach()
  set(SIZEOF_OFF_T 8)
  set(SIZEOF_SIZE_T 4)
  set(LIBZIP_TYPES_INCLUDE "#include <stdint.h>")
  foreach(bits IN ITEMS 8 16 32 64)
    set(ZIP_INT${bits}_T int${bits}_t)
    set(ZIP_UINT${bits}_T uint${bits}_t)
  endforeach()
  set(libzip "${BISS_WASM_SOURCES}/libzip")
  configure_file("${libzip}/cmake-config.h.in" "${PROJECT_BINARY_DIR}/libzip/config.h")
  configure_file("${libzip}/cmake-zipconf.h.in" "${wasm_headers}/zipconf.h")
endfunction()
wasm_configure_libzip()

# wasm_files(BEGIN NAME…): the files BEGIN NAME.c of BISS_WASM_SOURCES. JOINED: compiled as one.
set(wasm_sources)
function(wasm_files begin)
  cmake_parse_arguments(PARSE_ARGV 1 files "JOINED" "" "")
  list(TRANSFORM files_UNPARSED_ARGUMENTS REPLACE ".+" "${BISS_WASM_SOURCES}/${begin}\\0.c"
       OUTPUT_VARIABLE paths)
  if(files_JOINED)
    set_source_files_properties(${paths} PROPERTIES UNITY_GROUP libzip)
  endif()
  set(wasm_sources ${wasm_sources} ${paths} PARENT_SCOPE)
endfunction()
wasm_files(libdeflate/lib/ adler32 crc32 deflate_compress deflate_decompress gzip_compress
           gzip_decompress utils zlib_decompress)
wasm_files(zlib/ adler32 crc32 deflate inffast inflate inftrees trees zutil)
wasm_files(lz4/lib/ lz4)
wasm_files(libzstd/lib/common/ debug entropy_common error_private fse_decompress xxhash zstd_common)
wasm_files(libzstd/lib/decompress/ huf_decompress zstd_ddict zstd_decompress zstd_decompress_block)
wasm_files(libzip/lib/zip_ progress source_file_common source_file_stdio source_file_stdio_named
           source_pkware_encode)
wasm_files(libzip/lib/zip_ JOINED algorithm_deflate buffer dirent discard entry error extra_field
           fclose file_get_offset fopen_index fopen_index_encrypted fread
           get_encryption_implementation get_name get_num_entries hash io_util memdup mkstempm
           name_locate new open pkware random_unix stat_index stat_init string unchange_data utf-8)
wasm_files(libzip/lib/zip_source_ JOINED accept_empty buffer call close compress crc error free
           function get_file_attributes layered open pkware_decode read rollback_write seek stat
           supports tell tell_write window write zip_new)

# Optimised in every preset: the readers wait for these, and their warnings are for their authors.
add_library(biss_wasm_libraries STATIC ${wasm_sources})
target_include_directories(biss_wasm_libraries SYSTEM PUBLIC "${wasm_headers}"
                                               PRIVATE "${PROJECT_BINARY_DIR}/libzip")
target_compile_definitions(biss_wasm_libraries PRIVATE NDEBUG ZSTD_LEGACY_SUPPORT=0)
target_compile_options(biss_wasm_libraries PRIVATE -w -O3)
set_target_properties(biss_wasm_libraries PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
foreach(name IN ITEMS LIBZIP LIBDEFLATE LIBLZ4 ZLIB LIBZSTD)
  add_library(PkgConfig::${name} INTERFACE IMPORTED GLOBAL)
  target_link_libraries(PkgConfig::${name} INTERFACE biss_wasm_libraries)
endforeach()
