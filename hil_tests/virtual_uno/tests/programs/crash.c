/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Jumps out of the flash. */
int main(void)
{
    __asm__ volatile("ldi r30, 0xff\n\tldi r31, 0x7f\n\tijmp");
    return 0;
}
