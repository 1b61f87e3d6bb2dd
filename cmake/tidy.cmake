# The target `tidy` (presets tidy): clang-tidy on every source, by the compile commands of a build that is never
# made. A source is read again after it, a header or .clang-tidy has changed.

find_program(CLANG_TIDY clang-tidy REQUIRED)
file(GLOB_RECURSE TIDY_SOURCES CONFIGURE_DEPENDS src/*.c bench/*.c tests/*.c)
file(GLOB_RECURSE TIDY_HEADERS CONFIGURE_DEPENDS include/*.h src/*.h bench/*.h tests/*.h)
set(TIDY_DONE "")

# Reads a source; what follows its name is added to its compile command.
function(percale_tidy name source)
  cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE shown)
  set(done ${PROJECT_BINARY_DIR}/tidy/${name})
  list(TRANSFORM ARGN PREPEND --extra-arg= OUTPUT_VARIABLE extra)
  # Without carets clang doesn't count the warnings that .clang-tidy keeps from being seen.
  add_custom_command(OUTPUT ${done}
    COMMAND ${CLANG_TIDY} -p ${PROJECT_BINARY_DIR} --quiet --warnings-as-errors=* --extra-arg=-fno-caret-diagnostics
            ${extra} ${source}
    COMMAND ${CMAKE_COMMAND} -E touch ${done}
    DEPENDS ${source} ${TIDY_HEADERS} ${PROJECT_SOURCE_DIR}/.clang-tidy
    COMMENT "clang-tidy: ${shown} ${ARGN}" VERBATIM)
  set(TIDY_DONE ${TIDY_DONE} ${done} PARENT_SCOPE)
endfunction()

file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/tidy)
foreach(source ${TIDY_SOURCES})
  cmake_path(GET source FILENAME name)
  percale_tidy(${name} ${source})
endforeach()

# The engines share their sources; these are the ones that see what differs between them.
foreach(isa mavx2 mavx512vl)
  percale_tidy(closest_four_${isa} ${PROJECT_SOURCE_DIR}/src/detect/closest_four.c -${isa})
  percale_tidy(test_wide_${isa} ${PROJECT_SOURCE_DIR}/tests/test_wide.c -${isa})
endforeach()
percale_tidy(engine_choice_wide ${PROJECT_SOURCE_DIR}/src/engine_choice.c -DPERCALE_WIDE_ENGINES)

add_custom_target(tidy DEPENDS ${TIDY_DONE})
