# Writes the commit of the source tree SOURCE into FILE, as `git describe` names it; no file without a repository.
if(EXISTS "${SOURCE}/.git")
  execute_process(
    COMMAND git describe --always --dirty --abbrev=10 --exclude=*
    WORKING_DIRECTORY "${SOURCE}"
    OUTPUT_VARIABLE commit
    OUTPUT_STRIP_TRAILING_WHITESPACE
    RESULT_VARIABLE failed
    ERROR_QUIET)
  if(NOT failed)
    file(WRITE "${FILE}" "${commit}")
  endif()
endif()
