#include <hprad/context.h>
#include <stdio.h>

int main(void)
{
    puts("hprad");
    return 0;
}
