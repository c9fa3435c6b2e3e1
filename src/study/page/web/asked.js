// The order in which a person is asked for labels: nothing here needs a browser.

/**
 * The places of items, first those of whose answer the labeller is least sure; ties stay in order. Items without an answer come
 * last: the labeller cannot judge them, so it learns least from them.
 *
 * @param {number[]} certainties the probability of the labeller's answer for each item, 0 to 1; 0 if it has none
 * @returns {number[] | null} null if it is equally sure of all
 */
export function leastSureFirst(certainties) {
  if (certainties.every(certainty => certainty === certainties[0])) return null;
  /** @param {number} place */
  const rank = place => certainties[place] || 2;
  return certainties.map((_, place) => place).sort((a, b) => rank(a) - rank(b));
}

/**
 * The place that a person is asked for next: the first without a label. Places that the person has left without a label come
 * again after all others, in the order in which they were left.
 *
 * @param {number[]} order
 * @param {Set<number>} left
 * @param {(place: number) => boolean} labelled
 * @returns {number | undefined} undefined if all have labels
 */
export function nextAsked(order, left, labelled) {
  return [...order.filter(place => !left.has(place)), ...left].find(place => !labelled(place));
}

/** All places, from the one behind `place` round to itself. @param {number} place @param {number} count */
export const placesAfter = (place, count) => Array.from({ length: count }, (_, k) => (place + 1 + k) % count);
