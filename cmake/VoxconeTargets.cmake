# voxcone_room(NAME SOURCES... LINK libraries...): the static library voxcone_NAME of src/NAME.
add_library(voxcone_warnings INTERFACE)
# gcc 12 sees overlapping copies in std::string's operator+ where there are none (its bug 105651).
target_compile_options(voxcone_warnings INTERFACE -Wall -Wextra -Wconversion -Wshadow -Wno-restrict -Werror)

if(VOXCONE_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
  # Instrumented, gcc 12 no longer sees what the standard library initialises.
  target_compile_options(voxcone_warnings INTERFACE -Wno-maybe-uninitialized)
endif()

function(voxcone_room name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_library(voxcone_${name} STATIC ${ARG_SOURCES})
  target_include_directories(voxcone_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(voxcone_${name} PUBLIC ${ARG_LINK} PRIVATE voxcone_warnings)
endfunction()

# voxcone_test(NAME SOURCES... LINK libraries... [LAUNCHER command...]): a GoogleTest program; each of its tests becomes a ctest test.
# One ctest entry a program: contexts and scenes are shared inside it.
function(voxcone_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;LINK;LAUNCHER" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE VOXCONE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${ARG_LINK} voxcone_warnings GTest::gmock GTest::gtest_main)
  add_test(NAME ${name} COMMAND ${ARG_LAUNCHER} $<TARGET_FILE:${name}>)
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()
