# cmake -D LIBRARY=<build tree> -D WORK=<folder> -P run.cmake: installs the library, moves the installation, builds the
# consumer against it, runs it in its build tree and as a program that is installed beside the library, moved once more.
file(REMOVE_RECURSE "${WORK}")

# Runs a command, without what would say where assets are.
function(run)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env --unset=THREEWE_ASSETS --unset=THREEWE_PATH ${ARGN}
                  COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${LIBRARY} --prefix ${WORK}/prefix)
file(RENAME "${WORK}/prefix" "${WORK}/moved")
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/moved)
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer "${WORK}/moved/")
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/moved)
file(RENAME "${WORK}/moved" "${WORK}/moved_again")
run(${WORK}/moved_again/bin/consumer "${WORK}/moved_again/")
