// The time that the charts show.

const BEHIND = 0.035; // s
const FORGET = 0.002; // share of the lead that is forgotten with each message
const JUMP = 1; // s: the loop's time was set anew

/**
 * Messages do not come in step with the screen. So what is shown runs by the page's own clock, a little behind the newest
 * sample: each redraw moves by the same time, and by none when nothing comes any more.
 */
export class ScreenClock {
  constructor() { this.lead = null; } // of the loop's time over the page's, by the messages that were least on their way [s]

  /** A message came, whose newest sample has this time. */
  heard(newest) {
    const lead = newest - performance.now() / 1000;
    const earlier = this.lead;
    const isFresh = earlier === null || lead > earlier || lead < earlier - JUMP;
    this.lead = isFresh ? lead : earlier - FORGET * (earlier - lead);
  }

  /** The loop's time that is on screen at a time of the page [ms]. */
  shown(now, newest) {
    if (this.lead === null) return 0;
    return Math.min(newest, now / 1000 + this.lead - BEHIND);
  }
}
