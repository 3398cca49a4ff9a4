# SPDX-License-Identifier: Apache-2.0
# segserve_npm_packages(OUTPUT NAME FOLDER) installs the packages of FOLDER/package-lock.json, once, in the cache folder. OUTPUT
# becomes the folder node_modules with them, and NODE the program node; OUTPUT is empty where npm is not installed or cannot
# reach its registry. NAME is that of the folder in the cache.
function(segserve_npm_packages output name folder)
  set(${output} "" PARENT_SCOPE)
  find_program(NPM npm)
  find_program(NODE node)
  if(NOT NPM OR NOT NODE)
    message(STATUS "npm is not installed: what needs ${folder}/package.json is not built")
    return()
  endif()
  set(cache $ENV{XDG_CACHE_HOME})
  if(NOT cache)
    set(cache $ENV{HOME}/.cache)
  endif()
  file(SHA256 ${folder}/package-lock.json hash)
  string(SUBSTRING ${hash} 0 12 hash)
  set(installed ${cache}/segserve/${name}-${hash})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/package-lock.json)
  if(NOT EXISTS ${installed}/complete)
    file(COPY ${folder}/package.json ${folder}/package-lock.json DESTINATION ${installed})
    # No package runs a script of its own here.
    execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --loglevel=error
                    WORKING_DIRECTORY ${installed} TIMEOUT 300 RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE error)
    if(failed)
      message(WARNING "npm cannot install the packages of ${folder}, so that what needs them is not built: ${error}")
      return()
    endif()
    file(TOUCH ${installed}/complete)
  endif()
  set(${output} ${installed}/node_modules PARENT_SCOPE)
endfunction()
