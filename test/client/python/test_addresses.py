# SPDX-License-Identifier: Apache-2.0
"""Addresses of servers, and which to try next."""
import random
import unittest

from segserve._stream.address_book import AddressBook, Retry, parse_addresses


class Addresses(unittest.TestCase):
    def test_are_separated_by_commas(self):
        self.assertEqual(parse_addresses(" a:1, dns:///b:2 ,unix:/c"), ["a:1", "dns:///b:2", "unix:/c"])
        for wrong in ("", " ", ",", "a:1,", "a:1,,b:2"):
            with self.subTest(wrong), self.assertRaises(ValueError):
                parse_addresses(wrong)

    def test_without_a_port_have_the_default_one(self):
        self.assertEqual(parse_addresses("robot,10.0.0.7,[::1],fe80::1,[::1]:7"),
                         ["robot:50051", "10.0.0.7:50051", "[::1]:50051", "[fe80::1]:50051", "[::1]:7"])

    def test_urls_and_ports_that_are_none_are_refused(self):
        for wrong in ("http://robot:50051", "grpc://robot", "robot:50051/v1", "robot:", "robot:port", "robot:0",
                      "robot:65536", "robot:-1", ":7"):
            with self.subTest(wrong), self.assertRaisesRegex(ValueError, "address: "):
                parse_addresses(wrong)


class Waiting(unittest.TestCase):
    def test_doubles_up_to_a_limit_with_jitter_and_obeys_the_server(self):
        retry, rng = Retry(first_backoff=0.1, max_backoff=1), random.Random(3)
        for attempt, low, high in ((1, 0.05, 0.1), (3, 0.2, 0.4), (1000, 0.5, 1)):
            for _ in range(100):
                self.assertTrue(low <= retry.backoff(attempt, None, rng) <= high)
        self.assertEqual(retry.backoff(1, 5, rng), 5)

    def test_goes_on_to_the_next_and_comes_back_later(self):
        now = 3600.0
        book = AddressBook(2, 5, Retry(), 1)
        self.assertEqual(book.choose(now), (1, now))
        book.failed(1, now)
        self.assertEqual(book.choose(now).address, 0)
        self.assertFalse(book.nobody_in_reach())
        book.failed(0, now, 0.9)
        self.assertTrue(book.nobody_in_reach())
        self.assertEqual(book.choose(now).address, 1)
        self.assertGreater(book.choose(now).not_before, now)
        self.assertEqual(book.choose(now + 1).not_before, now + 1)
        book.reached(0)
        self.assertFalse(book.nobody_in_reach())
        self.assertEqual(book.choose(now).address, 0)

    def test_rules_that_make_no_sense_are_refused(self):
        for wrong in ({"max_attempts": 0}, {"first_backoff": 2, "max_backoff": 1}, {"first_backoff": 0}):
            with self.subTest(wrong), self.assertRaises(ValueError):
                Retry(**wrong)


if __name__ == "__main__":
    unittest.main()
