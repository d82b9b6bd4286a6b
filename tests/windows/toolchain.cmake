# SPDX-License-Identifier: GPL-3.0-or-later
# Cross-building for 64-bit Windows with mingw-w64; tests run under wine. ENF_WINDOWS_DEPS: the libraries' prefix.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
# The posix flavour has C11 threads and thread-local storage as the core uses them.
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ENF_WINDOWS_DEPS ENF_WINE)
set(CMAKE_FIND_ROOT_PATH ${ENF_WINDOWS_DEPS} /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# One DLL and nothing beside it: compiler runtime and winpthread are linked in.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "-static")
if(ENF_WINE)
    set(CMAKE_CROSSCOMPILING_EMULATOR ${ENF_WINE})
endif()
