# CMake's module starts seven interpreters each time, and the generators of a package of interfaces
# ask for the interpreter nine times: half of its configuration. The answer stays the same.

if(Python3_Interpreter_FOUND AND TARGET Python3::Interpreter
    AND Python3_FIND_COMPONENTS STREQUAL "Interpreter" AND NOT Python3_FIND_VERSION
    AND Python3_EXECUTABLE STREQUAL "${LAUNCHER_FOUND_PYTHON}")
  set(Python3_FOUND TRUE)
  return()
endif()

include("${CMAKE_ROOT}/Modules/FindPython3.cmake")
set(LAUNCHER_FOUND_PYTHON "${Python3_EXECUTABLE}")
