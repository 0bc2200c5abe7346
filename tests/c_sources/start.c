/* What a Cortex-M runs from reset on: it switches its floating-point unit on, and starts the program. */
extern void _start(void);

static void reset(void)
{
    /* CPACR: full access to the coprocessors 10 and 11 (ARMv7-M Architecture Reference Manual, B3.2.20). */
    *(volatile unsigned *)0xE000ED88u |= 0xFu << 20;
    __asm volatile("dsb\n\tisb");
    _start();
}

__attribute__((section(".vectors"), used)) static void (*const vectors[2])(void) = { (void (*)(void))0x20100000u, reset };
