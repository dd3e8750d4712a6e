# Completion of hprad for bash. Verbs and options it asks of the command itself, so it knows what this version knows.

_hprad()
{
    local command=${COMP_WORDS[0]} word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
    local verbs verb=
    verbs=$("$command" --help 2>/dev/null | sed -n 's/^ *or: hprad \([a-z]*\) .*/\1/p')
    if [[ " ${verbs//$'\n'/ } " == *" ${COMP_WORDS[1]} "* && $COMP_CWORD -gt 1 ]]; then
        verb=${COMP_WORDS[1]}
    fi
    COMPREPLY=()
    if [[ $word == -* ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$("$command" ${verb:+"$verb"} --help 2>/dev/null |
            grep -Eo '^ {2}(-[a-z], | {4})--[a-z-]+' | grep -Eo '[-]-[a-z-]+')" -- "$word")
        return
    fi
    local values=
    case $before in
    --direct) values="exact galerkin" ;;
    --filter) values="box gaussian" ;;
    --isa) values="auto sse2 avx2 avx512" ;;
    --metallic) values="diffuse black" ;;
    --method) values="galerkin hierarchical hemicube raycast exact" ;;
    --refine) values="h p hp" ;;
    --solver) values="auto gauss-seidel gmres gathering shooting direct" ;;
    esac
    if [[ $values ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$values" -- "$word")
        return
    fi
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
    if [[ $COMP_CWORD -eq 1 ]]; then
        mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -W "$verbs" -- "$word")
    fi
}

complete -o filenames -F _hprad hprad
