# SPDX-License-Identifier: BSD-3-Clause
# Writes the list of all translation effects: a header that includes every file of a folder, and names the type in each,
# which is the name of the file (quadratic_drag.h holds QuadraticDrag).
#
# m100_list_effects(HEADER FILE...), or as a script: cmake -DFOLDER=... -DHEADER=... -P list_effects.cmake

function(m100_list_effects header)
  set(includes "")
  set(types "")
  foreach(path IN LISTS ARGN)
    get_filename_component(file ${path} NAME)
    string(APPEND includes "#include \"firmware/model/translation/${file}\"\n")
    string(REGEX REPLACE "\\.h$" "" words ${file})
    string(REPLACE "_" ";" words ${words})
    set(type "")
    foreach(word IN LISTS words)
      string(SUBSTRING ${word} 0 1 first)
      string(SUBSTRING ${word} 1 -1 rest)
      string(TOUPPER ${first} first)
      string(APPEND type ${first}${rest})
    endforeach()
    list(APPEND types ${type})
  endforeach()
  list(JOIN types ", " types)
  set(text "// SPDX-License-Identifier: BSD-3-Clause
// Made by firmware/model/list_effects.cmake from the files of firmware/model/translation.
#pragma once

${includes}
namespace m100::model::translation {

template <typename... Effects>
struct List {};
using Listed = List<${types}>;

}  // namespace m100::model::translation
")
  if(EXISTS ${header})
    file(READ ${header} before)
  endif()
  if(NOT "${before}" STREQUAL "${text}")
    file(WRITE ${header} "${text}")  # only where it changes, so that nothing is compiled again without a reason
  endif()
endfunction()

if(CMAKE_SCRIPT_MODE_FILE AND CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  file(GLOB effects ${FOLDER}/*.h)
  m100_list_effects(${HEADER} ${effects})
endif()
