// Every header of the core needs C++20. An older language gives one clear error message.
#pragma once

#if __cplusplus < 202002L
#error "biss needs C++20: compile with -std=c++20"
#include <biss_needs_cxx20>  // does not exist, so that the compiler stops here
#endif

// The C++ library removes these macros of other headers too, whenever it is included after them.
#undef min
#undef max
