#include "spoil.h"

#include <math.h>
#include <string.h>

static void spoil_size(dice *dice, spoil_paper *paper, const spoil_struct *what) {
  /* Headers end at fields: a pointer is there, or it is not. */
  const uint32_t shapes[] = {
      0, 3, what->size + 2, what->size + 4, what->size + SPOIL_TAIL, what->size + SPOIL_TAIL + 4, UINT32_MAX - 3};
  const uint32_t cut = dice_below(dice, what->size / 8 + 1) * 8, choice = dice_below(dice, 10);
  const uint32_t given = choice < 7 ? shapes[choice] : cut;
  memcpy(paper->bytes, &given, sizeof given);
  if (dice_one_in(dice, 3)) /* a tail that is not zero */
    paper->bytes[what->size + dice_below(dice, 8)] = 1;
}

static void spoil_field_at(dice *dice, unsigned char *at, const spoil_field *field) {
  uint32_t whole = 0;
  uint64_t bits = dice_bits(dice);
  double real;
  float narrow;
  switch (field->kind) {
  case FIELD_WHOLE:
  case FIELD_SMALL:
    memcpy(&whole, at, sizeof whole);
    whole = field->kind == FIELD_SMALL ? dice_below(dice, field->most + 1) : dice_odd_whole(dice, whole);
    memcpy(at, &whole, sizeof whole);
    break;
  case FIELD_REAL:
    memcpy(&real, at, sizeof real);
    real = dice_odd_real(dice, real);
    memcpy(at, &real, sizeof real);
    break;
  case FIELD_FLOAT:
    memcpy(&narrow, at, sizeof narrow);
    real = dice_odd_real(dice, (double)narrow);
    narrow = (float)(isfinite(real) ? fmax(fmin(real, 3e38), -3e38) : real);
    memcpy(at, &narrow, sizeof narrow);
    break;
  case FIELD_LONG:
    bits = dice_one_in(dice, 2) ? bits : bits >> dice_below(dice, 64);
    memcpy(at, &bits, sizeof bits);
    break;
  case FIELD_POINTER:
    memset(at, 0, sizeof(void *));
    break;
  }
}

void spoil(dice *dice, spoil_paper *paper, const spoil_struct *what) {
  if (!what->count || dice_one_in(dice, 5)) {
    spoil_size(dice, paper, what);
    return;
  }
  const spoil_field *field = &what->fields[dice_below(dice, what->count)];
  const bool wide = field->kind == FIELD_LONG || field->kind == FIELD_REAL || field->kind == FIELD_POINTER;
  const uint32_t each = wide ? 8 : 4;
  spoil_field_at(dice, paper->bytes + field->offset + dice_below(dice, field->size / each) * each, field);
}
