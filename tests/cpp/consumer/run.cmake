# cmake -D LIBRARY=<build tree> -D WORK=<folder> -P run.cmake: installs the library, builds the consumer, runs it
# with the installed assets.
file(REMOVE_RECURSE "${WORK}")
foreach(command IN ITEMS
    "${CMAKE_COMMAND};--install;${LIBRARY};--prefix;${WORK}/prefix"
    "${CMAKE_COMMAND};-S;${CMAKE_CURRENT_LIST_DIR};-B;${WORK}/build;-G;Ninja;-DCMAKE_PREFIX_PATH=${WORK}/prefix"
    "${CMAKE_COMMAND};--build;${WORK}/build"
    "${WORK}/build/consumer")
  execute_process(COMMAND ${CMAKE_COMMAND} -E env "THREEWE_ASSETS=${WORK}/prefix/share/threewe/assets" ${command}
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()
