# Libraries for WebAssembly. Debian has no libraries for it; these are headers alone, or the few
# functions of wasm/libraries/.
if(NOT CMAKE_CXX_COMPILER_VERSION)
  message(FATAL_ERROR "BissWasm needs the toolchain file of emscripten")
endif()

# /usr/include itself holds the headers of this machine's C library.
set(wasm_headers "${PROJECT_BINARY_DIR}/headers")
file(MAKE_DIRECTORY "${wasm_headers}")
foreach(folder IN ITEMS boost CLI fmt hwy nlohmann tl)
  if(NOT IS_DIRECTORY "/usr/include/${folder}")
    message(FATAL_ERROR "/usr/include/${folder} is missing; scripts/install-packages wasm")
  endif()
  file(CREATE_LINK "/usr/include/${folder}" "${wasm_headers}/${folder}" SYMBOLIC)
endforeach()

add_library(biss_wasm_headers INTERFACE)
target_include_directories(biss_wasm_headers SYSTEM INTERFACE "${wasm_headers}")
target_compile_definitions(biss_wasm_headers INTERFACE FMT_HEADER_ONLY)
target_link_libraries(biss_wasm_headers INTERFACE $<LINK_ONLY:biss_wasm_libraries>)
foreach(name IN ITEMS fmt::fmt nlohmann_json::nlohmann_json hwy::hwy CLI11::CLI11 Threads::Threads)
  add_library(${name} INTERFACE IMPORTED GLOBAL)
  target_link_libraries(${name} INTERFACE biss_wasm_headers)
endforeach()
foreach(name IN ITEMS LIBZIP LIBDEFLATE LIBLZ4 ZLIB LIBZSTD)
  add_library(PkgConfig::${name} INTERFACE IMPORTED GLOBAL)
  target_link_libraries(PkgConfig::${name} INTERFACE biss_wasm_libraries)
endforeach()
